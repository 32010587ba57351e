// Where the search for the nearest texel on skin starts: such texels know themselves, others nothing yet.
SAMPLER(source);  // a: 0 where empty

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = read_texel(source, p).a > 0.0 ? vec4(vec2(p), 0.0, 0.0) : vec4(-1.0);
  WRITE_COUNTS;
}
