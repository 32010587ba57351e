// Adds one level of the texture-space blur, read at the pixel's uv, to the picture (by blending). With
// COVERAGE the empty texels are divided out, and a pixel whose four texels are all empty keeps its irradiance.
// With BICUBIC it is read by Catmull and Rom's cubic over 4 x 4 texels.
SAMPLER(irradiance);
SAMPLER(surface_uv);
SAMPLER(level);
uniform vec3 weight;

#ifdef BICUBIC
vec4 catmull_rom_weights(float t) {
  vec4 powers = vec4(1.0, t, t * t, t * t * t);
  return 0.5 * vec4(dot(powers, vec4(0.0, -1.0, 2.0, -1.0)), dot(powers, vec4(2.0, 0.0, -5.0, 3.0)),
                    dot(powers, vec4(0.0, 1.0, 4.0, -3.0)), dot(powers, vec4(0.0, 0.0, -1.0, 1.0)));
}

vec4 read_level(vec2 uv) {
  ivec2 size = textureSize(level, 0);
  vec2 place = uv * vec2(size) - 0.5;
  vec2 whole = floor(place);
  vec4 wx = catmull_rom_weights(place.x - whole.x);
  vec4 wy = catmull_rom_weights(place.y - whole.y);
  vec4 sum = vec4(0.0);
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i)
      sum += wx[i] * wy[j] * read_texel(level, clamp(ivec2(whole) + ivec2(i - 1, j - 1), ivec2(0), size - 1));
  }
  return sum;
}
#else
vec4 read_level(vec2 uv) { return read_linear(level, uv); }
#endif

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 center = read_texel(irradiance, p);
  result = vec4(0.0);
  if (center.a > 0.0) {
    vec4 blurred = read_level(read_texel(surface_uv, p).xy);
#ifdef COVERAGE
    blurred.rgb = blurred.a > 0.0 ? blurred.rgb / blurred.a : center.rgb;
#endif
    result = vec4(weight * blurred.rgb, 0.0);
  }
  WRITE_COUNTS;
}
