// The alpha of a level, or of the map that is not blurred yet, at every pixel's uv.
SAMPLER(surface_uv);
SAMPLER(level);

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(0.0);
  if (is_drawn(p)) result = vec4(read_linear(level, read_texel(surface_uv, p).xy).a);
  WRITE_COUNTS;
}
