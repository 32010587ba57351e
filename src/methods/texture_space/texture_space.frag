// texture-space: one axis of one blur of texture-space diffusion (d'Eon & Luebke 2007; Yang et al. section
// II B; the walkthrough's convolution passes).
//
// Passes: irradiance and stretch into texture space; then for each variance v_i, ascending, a u pass and a v
// pass on the previous level with the variance v_i - v_(i-1) (Yang et al. equation 5); after each level a
// screen pass adds w_i times it, read bilinearly at the pixel's uv.
// Blur: seven taps at -3..3 standard deviations with the published weights, their spacing
// sqrt(v_i - v_(i-1)) * (texels per mm at this texel and axis), from the stretch map. Those weights sum to
// 1.001 and have variance 1.079 s^2; here they are divided by the sum of those that fell on skin, which takes
// care of 1.001 and of seams: texels outside the charts count as nothing rather than as black.
// (The walkthrough blurs every level by one constant width and takes albedo for irradiance: its pass
// structure is reproduced, not that. It also takes irradiance itself for the first Gaussian; we blur it.)
//
// Settings: texture_size (1024), stretch: raw (per texel) | off (the chart's mean everywhere).
// Fails: at seams (light does not cross), where UV is sheared or stretch changes within the filter, below a
//   texel (the narrow Gaussians), on overlapping charts; through thin parts (no transmittance). The stretch
//   of a uv axis is not that of its perpendicular where the map is sheared. A tap that jumps the gutter between
//   two charts reads the other chart's light as if it were near: the widest level of the six Gaussians reaches
//   3 sqrt(7.41 - 1.99) = 7 mm, 21 texels of 1024 at the built-in head's median of 3.1 texels per mm, and that
//   head's gutters are 10 texels wide.
//
// Limits. Constant: weights are normalised, to float rounding 1e-5 (bilinear weights on unit alpha). Identity:
// no narrower than a texel: at s -> 0 what remains is the bilinear reading of point-sampled irradiance, whose
// error is at most half a texel's diagonal, 0.71 texels, times the irradiance's gradient. Mirror: uvs are the
// mesh's, so the map is the same; the reading rounds by 1e-6 of the map's width: 1e-5.
SAMPLER(source);   // rgb: irradiance times alpha, a: coverage
SAMPLER(stretch);  // rg: texels per mm
uniform int axis;
uniform float std_dev_mm;
uniform float mean_texels_per_mm;  // > 0: the stretch map is off

const float kWeights[4] = float[](0.383, 0.242, 0.061, 0.006);

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec2 size = vec2(textureSize(source, 0));
  vec4 center = read_texel(source, p);
  result = center;
  if (center.a > 0.0) {
    float texels_per_mm = mean_texels_per_mm > 0.0 ? mean_texels_per_mm : read_texel(stretch, p)[axis];
    vec2 direction = (axis == 0 ? vec2(1.0, 0.0) : vec2(0.0, 1.0)) * std_dev_mm * texels_per_mm;
    vec4 sum = kWeights[0] * center;
    for (int i = 1; i < 4; ++i) {
      vec2 step_px = float(i) * direction;
      sum += kWeights[i] * read_linear(source, (gl_FragCoord.xy - step_px) / size);
      sum += kWeights[i] * read_linear(source, (gl_FragCoord.xy + step_px) / size);
    }
    result = vec4(sum.rgb / sum.a, 1.0);
  }
  WRITE_COUNTS;
}
