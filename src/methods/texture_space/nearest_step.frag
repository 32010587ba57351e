// One round of jump flooding (Rong & Tan 2006): out of what this texel and the eight at a distance of `jump`
// along the axes and diagonals know, the nearest texel on skin. A few texels end with one that is not quite the
// nearest, by less than a texel in nearly all.
SAMPLER(nearest);  // rg: a texel on skin; negative: none known
uniform int jump;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  ivec2 size = textureSize(nearest, 0);
  vec2 best = read_texel(nearest, p).xy;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      ivec2 from = p + jump * ivec2(x, y);
      if (!inside(from, size)) continue;
      vec2 known = read_texel(nearest, from).xy;
      if (known.x < 0.0) continue;
      vec2 there = known - vec2(p);
      vec2 here = best - vec2(p);
      if (best.x < 0.0 || dot(there, there) < dot(here, here)) best = known;
    }
  }
  result = vec4(best, 0.0, 0.0);
  WRITE_COUNTS;
}
