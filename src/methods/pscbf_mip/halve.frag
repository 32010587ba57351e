// A level of pscbf_mip.frag's chain from the next finer one: pairs along one axis. Both skin and no more than gap_mm
// apart in depth: their mean. Farther apart: the nearer of the two alone. One of them: that one.
SAMPLER(finer);
uniform int axis;
uniform float gap_mm;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  ivec2 first = axis == 0 ? ivec2(2 * p.x, p.y) : ivec2(p.x, 2 * p.y);
  ivec2 second = first + (axis == 0 ? ivec2(1, 0) : ivec2(0, 1));
  vec4 a = read_texel(finer, first);
  vec4 b = inside(second, textureSize(finer, 0)) ? read_texel(finer, second) : vec4(0.0);
  if (a.a == 0.0 || b.a == 0.0) {
    result = a + b;
  } else if (abs(a.a - b.a) <= gap_mm) {
    result = 0.5 * (a + b);
  } else {
    result = a.a < b.a ? a : b;
  }
  WRITE_COUNTS;
}
