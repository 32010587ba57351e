// Adds one level of the texture-space blur, read at the pixel's uv, to the picture (by blending). With
// COVERAGE the empty texels are divided out, and a pixel whose four texels are all empty keeps its irradiance.
SAMPLER(surface_uv);
uniform vec3 weight;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(0.0);
  if (is_drawn(p)) {
    vec4 blurred = read_level(read_texel(surface_uv, p).xy);
#ifdef COVERAGE
    blurred.rgb = blurred.a > 0.0 ? blurred.rgb / blurred.a : read_texel(irradiance, p).rgb;
#endif
    result = vec4(weight * blurred.rgb, 0.0);
  }
  WRITE_COUNTS;
}
