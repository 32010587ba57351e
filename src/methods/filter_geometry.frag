// What bounds a filter around a pixel, for who wants to look at it: along x and y the extent d' of its disc in pixels or,
// with SCALE, K in mm per pixel (filter_geometry.glsl). 0 off the skin.
SAMPLER(position);
SAMPLER(normal);
SAMPLER(irradiance);
uniform float r_max_mm;
uniform float focal_px;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(0.0);
  if (read_texel(irradiance, p).a > 0.0) {
    vec3 x = read_texel(position, p).xyz;
    vec3 n = read_texel(normal, p).xyz;
#ifdef SCALE
    result.xy = vec2(linear_scale(x, n, 0, r_max_mm), linear_scale(x, n, 1, r_max_mm)) / focal_px;
#else
    result.xy = 2.0 * focal_px * vec2(disc_half_extent(x, n, 0, r_max_mm), disc_half_extent(x, n, 1, r_max_mm));
#endif
  }
  WRITE_COUNTS;
}
