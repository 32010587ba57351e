// One level of the texture-space blur at a uv: bilinear, or with BICUBIC by Catmull and Rom's cubic over 4 x 4 texels.
SAMPLER(level);

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
