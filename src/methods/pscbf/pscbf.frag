// pscbf: one axis of Mikkelsen's pseudo-separable cross bilateral filter (2010), equation 8.
//
// Section 5: the filter is bounded by the disc of radius r_max in the tangent plane, whose extent on the plane
// z = -1 along axis a is d'_a = d_a cos(phi_a); d_a is the extent of the sphere's projection (figure 2), and phi_a
// the angle between normal and viewer in the (a, z) plane, by the interpolated normal (filter_geometry.glsl).
//
// N taps of equal probability 1/N under the red channel's Gaussian are laid proportionally over d':
// tap i at t_i d' / 2 with t_i = q_i s_red / r_max, and q_i the median (or centroid) of the i-th of N bins of
// a unit Gaussian. Green and blue weights are their own Gaussians' masses in the red bins. Each tap is
// weighted by exp(-dE^2 / 2 s_c^2), E being the depth; taps off the skin or the frame are dropped; weights
// are normalised per channel. Nearest sampling: neighbours on the screen may be far apart on the surface.
//
// Open in the source: the cut at r_max does not move the taps (q_i are quantiles of the whole Gaussian); so r_max,
// which t_i divides by and d' grows with, hardly matters, and a tap may lie beyond it.
// `sampling` = dense reads every pixel within d'/2 instead: pixel i at t = i / (d'/2) has the weight
// exp(-(t r_max)^2 / 2 s_c^2), averaged over the pixel where that is longer than s / 2 (24 cells at most), and the
// last counts by how much of it lies inside. Two such passes are cut off by a square, not a disc.
// `sharing` = none gives each channel N taps of its own, at three times the reads.
// `targets` = 16-bit writes every pass in half precision, 11 bits; the frame's irradiance stays as it is.
//
// Settings: taps (N, 13), placement (median | centroid), r_max_mm (0: the profile's; table 1: 4.5 mm), sampling
//   (taps | dense; dense has no use for taps, placement and sharing), sharing (red | none), targets (32-bit |
//   16-bit). The two readings of table 1 are profiles: spike-and-base and spike-and-base-sigma.
// Fails: slopes, for d' at r_max already places taps at surface distance and the depth term counts the
//   slope again (variance along it s^2 / (1 + sin^2 theta)); the variance lost to N taps (0.907 s^2 for 13
//   medians); pseudo-separability on curved surfaces; taps below a pixel (nearest sampling rounds them);
//   light that arrives from hidden surface, and thin parts (an ear's truth loses light to its dark back, or
//   gains it from a lit one: the filter sees the front alone).
//
// Limits. Constant: normalised, so to float rounding, 1e-6. Identity: once the outermost tap lies within half
// a pixel, every tap reads the centre: exactly the identity (to rounding, 1e-6). Mirror: taps are symmetric
// and rounded away from the centre alike, so to rounding of exp and sums, 1e-5.
SAMPLER(source);
SAMPLER(position);
SAMPLER(normal);
uniform int axis;
uniform float r_max_mm;
uniform float focal_px;
uniform int tap_count;
uniform float narrowest_mm;            // smallest and largest s_c
uniform float widest_mm;
uniform float tap_offset[MAX_TAPS];    // t_i, in units of d' / 2
uniform vec3 tap_weight[MAX_TAPS];     // probability per channel
uniform vec3 depth_factor;             // -1 / 2 s_c^2 per channel

vec3 light_sum = vec3(0.0);
vec3 weight_sum = vec3(0.0);

void add_tap(ivec2 p, int offset_px, float depth_mm, vec3 weight) {
  ivec2 q = p + (axis == 0 ? ivec2(offset_px, 0) : ivec2(0, offset_px));
  if (!inside(q, textureSize(source, 0))) return;
  vec4 tap = read_texel(source, q);
  if (tap.a == 0.0) return;
  float step_mm = read_texel(position, q).z - depth_mm;
  vec3 w = weight * exp(step_mm * step_mm * depth_factor);
  light_sum += w * tap.rgb;
  weight_sum += w;
}

#ifdef DENSE
void add_taps(ivec2 p, float depth_mm, float reach_px) {
  float mm_per_px = r_max_mm / reach_px;
  int cells = int(clamp(ceil(2.0 * mm_per_px / narrowest_mm), 1.0, 24.0));
  // Beyond 5.5 s lies nothing: 4e-8 of the light.
  int last = int(ceil(min(reach_px, 5.5 * widest_mm / mm_per_px)));
  for (int i = -last; i <= last; ++i) {
    vec3 weight = vec3(0.0);
    for (int cell = 0; cell < cells; ++cell) {
      float t_mm = (float(i) + (float(cell) + 0.5) / float(cells) - 0.5) * mm_per_px;
      weight += exp(t_mm * t_mm * depth_factor);
    }
    add_tap(p, i, depth_mm, clamp(0.5 + reach_px - abs(float(i)), 0.0, 1.0) * weight);
  }
}
#else
void add_taps(ivec2 p, float depth_mm, float reach_px) {
  for (int i = 0; i < tap_count; ++i) {
    float offset_px = tap_offset[i] * reach_px;
    add_tap(p, int(sign(offset_px) * floor(abs(offset_px) + 0.5)), depth_mm, tap_weight[i]);
  }
}
#endif

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 center = read_texel(source, p);
  result = center;
  if (center.a > 0.0) {
    vec3 x = read_texel(position, p).xyz;
    add_taps(p, x.z, disc_half_extent(x, read_texel(normal, p).xyz, axis, r_max_mm) * focal_px);
    // An even number of taps has none at the centre: on a lone pixel all may have been dropped.
    bvec3 any_weight = greaterThan(weight_sum, vec3(1e-30));
    result = vec4(mix(center.rgb, light_sum / max(weight_sum, vec3(1e-30)), vec3(any_weight)), center.a);
  }
  WRITE_COUNTS;
}
