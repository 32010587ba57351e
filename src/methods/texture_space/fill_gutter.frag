// Gives every empty texel what the nearest texel on skin has.
SAMPLER(source);   // a: 0 where empty
SAMPLER(nearest);  // rg: that texel; negative without one

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = read_texel(source, p);
  if (result.a == 0.0) {
    ivec2 from = ivec2(read_texel(nearest, p).xy);
    if (from.x >= 0) result = read_texel(source, from);
  }
  WRITE_COUNTS;
}
