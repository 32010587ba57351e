// screen-gaussian: one axis of the separable screen-space Gaussian of Jimenez, Sundstedt & Gutierrez 2009,
// whose width follows depth and slope. Naive: it has no depth test and no mask on its taps.
//
// Source: width at a pixel = alpha / (d + beta min(|grad d|, max_gradient)), per axis, with d the depth and
//   grad d its screen-space derivative (here, as there, the hardware's); seven bilinear taps at -3..3 standard
//   deviations with weights .006 .061 .242 .382 .242 .061 .006 (they sum to 1); Gaussians applied one on top
//   of the other with the differences of their variances.
// What the source leaves open, and what we take:
//   alpha   a strength tuned by eye; ours is physical: alpha = s * focal_px, so that a facing surface is
//           blurred by s millimetres.
//   beta    tuned by eye; ours is slope_beta * focal_px: with a plane's |grad d| = (d / focal_px) tan(theta)
//           the width falls as 1 / (1 + slope_beta tan(theta)); the true factor is cos(theta).
//   max_gradient  a constant in the source's depth units; ours is max_gradient_mm, per pixel, 0 for no bound.
// Fails: halo at silhouettes (the background is 0 and bleeds in), leak across depth gaps, slopes (the factor
//   above is not the cosine: at 45 degrees 1 / (1 + 1) = 0.5 against 0.71), and where two pixels of
//   a 2 x 2 block lie on different surfaces (a derivative across the gap: width near 0).
//
// Taps beyond the frame read its border again (clamped), as the source's sampler does.
//
// Limits. Constant: the weights sum to 1 to 1e-7, so to float rounding where all taps lie on lit surface.
// Identity: taps at 3 s px read bilinearly, so the error is <= 2 * (.006*3 + .061*2 + .242) s_px = 0.76 s_px
// times the largest step between neighbouring pixels, per axis and level. Mirror: hardware derivatives are
// one-sided within 2 x 2 blocks, which mirroring maps onto each other for an even width; depths of some 300 mm
// round to 1.5e-5 mm, so tan(theta), a difference over a pixel of 0.5 mm, and with it the width, to 6e-5 of
// itself, and a level of 5 px under steps of 0.05 to 0.76 * 5 * 0.05 * 6e-5 = 1.2e-5; with the sums, 2e-5.
SAMPLER(source);
SAMPLER(position);
uniform int axis;
uniform float std_dev_mm;
uniform float focal_px;
uniform float slope_beta;
uniform float max_gradient_mm;

const float kWeights[4] = float[](0.382, 0.242, 0.061, 0.006);

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec2 size = vec2(textureSize(source, 0));
  vec4 center = read_texel(source, p);
  float depth_mm = -read_texel(position, p).z;
  float gradient_mm = abs(axis == 0 ? dFdx(depth_mm) : dFdy(depth_mm));
  result = center;
  if (center.a > 0.0) {
    if (max_gradient_mm > 0.0) gradient_mm = min(gradient_mm, max_gradient_mm);
    float std_dev_px = std_dev_mm * focal_px / (depth_mm + slope_beta * focal_px * gradient_mm);
    vec2 direction = (axis == 0 ? vec2(1.0, 0.0) : vec2(0.0, 1.0)) * std_dev_px;
    vec3 sum = kWeights[0] * center.rgb;
    for (int i = 1; i < 4; ++i) {
      vec2 step_px = float(i) * direction;
      sum += kWeights[i] * read_linear(source, (gl_FragCoord.xy - step_px) / size).rgb;
      sum += kWeights[i] * read_linear(source, (gl_FragCoord.xy + step_px) / size).rgb;
    }
    result = vec4(sum, center.a);
  }
  WRITE_COUNTS;
}
