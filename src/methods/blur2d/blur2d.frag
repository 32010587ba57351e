// blur2d: one axis of a regular two-dimensional Gaussian in screen space, of fixed size.
//
// Source: the comparison of Mikkelsen 2010, figure 3(a).
// Width: std_dev_px = s * focal_px / (median depth of the view's skin), the same at every pixel.
// Taps: every pixel within 4 std_dev_px, weight exp(-i^2 / 2 std_dev_px^2), normalised over the taps.
//       No mask and no depth: the background is 0 and bleeds in, skin bleeds out. Taps beyond the frame are
//       dropped: what lies there is not known, and its loss would be the crop's error, not the method's.
// Fails: at silhouettes (dark rim inside, the halo), across depth gaps (leak), on slopes (too wide along
//       the slope), away from the median depth (too wide nearer, too narrow farther... by the ratio of depths).
//
// Limits. Constant: exact to float rounding (<= 2e-6 relative: at most 2 * 4s+1 additions of weights that are
// divided by their own sum) where all taps lie on the lit surface; at a border it loses light by design.
// Identity: at s -> 0 the neighbours' weight exp(-1 / 2 std_dev_px^2) is below 1e-10 at 0.15 px. Mirror:
// taps are symmetric, so up to the order of float additions (2e-6).
SAMPLER(source);
uniform int axis;
uniform float std_dev_px;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  ivec2 size = textureSize(source, 0);
  ivec2 direction = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
  int radius = int(ceil(4.0 * std_dev_px));
  float factor = -0.5 / (std_dev_px * std_dev_px);
  vec4 center = read_texel(source, p);
  vec3 sum = center.rgb;
  float weights = 1.0;
  for (int i = 1; i <= radius; ++i) {
    float w = exp(float(i * i) * factor);
    ivec2 left = p - i * direction;
    ivec2 right = p + i * direction;
    if (inside(left, size)) {
      sum += w * read_texel(source, left).rgb;
      weights += w;
    }
    if (inside(right, size)) {
      sum += w * read_texel(source, right).rgb;
      weights += w;
    }
  }
  result = vec4(sum / weights, center.a);
  WRITE_COUNTS;
}
