// texture-space: one axis of one blur of texture-space diffusion (d'Eon & Luebke 2007; Yang et al. section
// II B; the walkthrough's convolution passes).
//
// Passes: irradiance and stretch into texture space, and their gutters; then for each variance v_i, ascending,
// a u pass and a v pass on the previous level with the variance v_i - v_(i-1) (Yang et al. equation 5); after
// each level a screen pass adds w_i times it, read bilinearly at the pixel's uv.
// Blur: per axis with the standard deviation s_px = sqrt(v_i - v_(i-1)) * (texels per mm at this texel along
// this axis), from the stretch map. The sources take texels per mm as 1 / |dP/du|: exact where u and v are
// perpendicular on the surface.
//
// Settings:
//   texture_size  texels along each side (1024; the sources: 1024 and, Yang et al., 4096).
//   stretch       raw: per texel. blurred: before the irradiance's, each level blurs the stretch map too, with
//                 the same taps, their spacing out of the map that it blurs (Yang et al. figure 3; the
//                 walkthrough), so that level i is corrected by a map blurred i times. off: the skin's mean
//                 everywhere.
//   taps          seven: the published weights at -3..3 s_px, read bilinearly. They sum to 1.001 and have the
//                 variance 1.079 s^2; here they are divided by their sum. seven-published: they are not, as in
//                 the sources, so that level i is 1.001^2i times too bright: 1.2 % at the sixth.
//                 dense: every texel within 5 s_px + 2, with the discrete Gaussian exp(-t) I_n(t), t = s_px^2
//                 (Lindeberg 1990; I_n the modified Bessel function). Its variance is t for any t, also below
//                 a texel, and its convolutions add up exactly as Gaussians do; a sampled Gaussian has neither.
//   first_gaussian blurred: by v_1. irradiance: the unblurred irradiance stands for the first level, as the
//                 walkthrough has it; the increments stay v_i - v_(i-1), so every level lacks v_1.
//   gutter        What taps and readings beyond a chart's edge find. nearest: a copy of the nearest texel on
//                 skin, in the irradiance and in the stretch map, found by jump flooding when the method is
//                 made (texture coordinates do not move); the maps are then blurred everywhere. So a chart goes
//                 on beyond its edge as it was there, and no reading finds an empty texel. coverage: texels
//                 off the skin count as nothing, and each blur is divided by the taps' weight on skin. none:
//                 they are black, and their stretch is 0.
//                 None of them lets light cross a seam: beyond it is what the same chart has, not what the
//                 surface has. At a seam across which irradiance goes on with the slope g, a half of the
//                 kernel is wrong: by s g / sqrt(2 pi) with nearest, twice that with coverage.
//   passes        incremental: each level is blurred out of the one before it, as in the sources. direct: out of
//                 the irradiance, drawn anew, by its whole variance (what increments are measured against: taps
//                 spread along texel rows do not add up where the stretch changes).
//   reading       of a level at a pixel: bilinear as in the sources, or bicubic (Catmull and Rom), whose error
//                 is of third order in the texel and which overshoots at steps by up to 1/8 of them.
// Several characters (copies of one mesh, so with one UV map between them): one after the other through the same
//   textures, all passes but the first for each; those that no pixel of skin in view belongs to are left out.
//   Gathering goes over the rectangle of a character's pixels and tells them by the frame's number of it.
//
// (The walkthrough blurs every level by one constant width and takes albedo for irradiance: its pass
// structure is reproduced, not that.)
//
// Fails: at seams (above); where UV is sheared or stretch changes within the filter; below a texel with seven
//   taps (bilinear reading adds up to a quarter of a texel^2 to the variance of each tap); on overlapping
//   charts; through thin parts (no transmittance). A chart that holds no texel's centre reads its neighbours'
//   light (with coverage: keeps its irradiance where all four texels are empty). A tap that jumps the gutter
//   between two charts reads the other chart's light as if it were near, and so does with `nearest` a tap
//   beyond the gutter's middle: the widest level of the six Gaussians reaches 3 sqrt(7.41 - 1.99) = 7 mm, 21
//   texels of 1024 at the built-in head's median of 3.1 texels per mm, and that head's gutters are 10 wide.
//
// Cost, for L levels on N^2 texels: 2 + L (2 + 1) screen or map passes beside the geometry's one, each with
//   raw stretch one more geometry pass and with `nearest` one more for each map; blurred stretch: 2 L more.
//   Texels read per blurred texel and axis: seven 26 (stretch off: 25), dense 2 + 2 (5 s_px + 2); s_px is at
//   most (N - 2) / 5, so that a texel of a collapsed triangle reads 2 N at most. Per pixel of skin and level
//   6. Memory: 32 bytes a texel, 64 with a stretch map, 8 more with `nearest`: at most 72 N^2, 1.2 GB at
//   4096 (a whole run then took 2.6 GB); while reads are counted 32 more. Each level is gathered before the
//   next takes its place, so L does not count. Of K characters in view: K times the passes after the first and
//   the texels read, and with `nearest` 8 bytes a texel for each.
//
// Limits. Constant: weights are normalised, to float rounding: 26 readings and sums an axis, six levels:
// 1e-5. Identity: no narrower than a texel: as s -> 0 what remains is the bilinear reading of point-sampled
// irradiance. Inside a chart it is that of a linear function but for curvature; within a texel of a chart's
// edge what is read lies up to a texel inwards along each axis: sqrt(2) times irradiance's largest change
// along a texel's edge, for charts with square corners. Mirror: uvs are the mesh's, so the map is the same;
// the reading rounds by 1e-6 of the map's width: 1e-5.
SAMPLER(source);   // rgb: irradiance, or texels per mm along u and v; a: > 0 where there is some
SAMPLER(stretch);  // rg: texels per mm
uniform int axis;
uniform float std_dev_mm;
uniform float mean_texels_per_mm;  // > 0: the stretch map is off
uniform float gain;                // what the taps' weights are to sum to

const float kWeights[4] = float[](0.383, 0.242, 0.061, 0.006);

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  ivec2 size = textureSize(source, 0);
  vec4 center = read_texel(source, p);
  result = center;
#ifdef COVERAGE
  if (center.a > 0.0)
#endif
  {
    float texels_per_mm = mean_texels_per_mm > 0.0 ? mean_texels_per_mm : read_texel(stretch, p)[axis];
    float std_dev_px = min(std_dev_mm * texels_per_mm, float(size[axis] - 2) / 5.0);
    vec4 sum = vec4(0.0);
    float total = 0.0;
#ifdef DENSE
    // From far to near, as the recurrence I_(n-1) = I_(n+1) + 2n/t I_n is stable; the scale divides out. It
    // starts from a number so small that t = 1e-12 does not overflow, and below that nothing is blurred.
    float t = std_dev_px * std_dev_px;
    float farther = 0.0;
    float weight = 1e-30;
    int reach = t > 1e-12 ? int(ceil(5.0 * std_dev_px)) + 2 : 0;
    ivec2 direction = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
    for (int n = reach; n > 0; --n) {
      sum += weight * read_texel(source, max(p - n * direction, ivec2(0)));
      sum += weight * read_texel(source, min(p + n * direction, size - 1));
      total += 2.0 * weight;
      float nearer = farther + 2.0 * float(n) / t * weight;
      farther = weight;
      weight = nearer;
    }
    sum += weight * center;
    total += weight;
#else
    vec2 direction = (axis == 0 ? vec2(1.0, 0.0) : vec2(0.0, 1.0)) * std_dev_px;
    sum = kWeights[0] * center;
    total = kWeights[0];
    for (int i = 1; i < 4; ++i) {
      vec2 step_px = float(i) * direction;
      sum += kWeights[i] * read_linear(source, (gl_FragCoord.xy - step_px) / vec2(size));
      sum += kWeights[i] * read_linear(source, (gl_FragCoord.xy + step_px) / vec2(size));
      total += 2.0 * kWeights[i];
    }
#endif
#ifdef COVERAGE
    total = sum.a;
#endif
#ifdef BLURS_ALPHA
    result = gain * sum / total;
#else
    result = vec4(gain * sum.rgb / total, 1.0);
#endif
  }
  WRITE_COUNTS;
}
