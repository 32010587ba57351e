// pscbf: one axis of Mikkelsen's pseudo-separable cross bilateral filter (2010), equation 8.
//
// Section 5: the filter is bounded by the disc of radius r_max in the tangent plane, whose extent on the plane
// z = -1 along axis a is d'_a = d_a cos(phi_a); d_a is the extent of the sphere's projection (figure 2). With
// (x_a, z) of the pixel's point and the (a, z) parts of the interpolated normal n and of the direction omega
// to the viewer, renormalised:
//
//   alpha = atan2(x_a, -z),  D = sqrt(x_a^2 + z^2),  beta = asin(r_max / D)
//   d_a = tan(alpha + beta) - tan(alpha - beta),     cos(phi_a) = max(n_a . omega_a, 1e-3)
//
// N taps of equal probability 1/N under the red channel's Gaussian are laid proportionally over d':
// tap i at t_i d' / 2 with t_i = q_i s_red / r_max, and q_i the median (or centroid) of the i-th of N bins of
// a unit Gaussian. Green and blue weights are their own Gaussians' masses in the red bins. Each tap is
// weighted by exp(-dE^2 / 2 s_c^2), E being the depth; taps off the skin or the frame are dropped; weights
// are normalised per channel. Nearest sampling: neighbours on the screen may be far apart on the surface.
//
// Open in the source: the cut at r_max does not move the taps (q_i are quantiles of the whole Gaussian).
//
// Settings: taps (N, 13), placement (median | centroid). r_max comes with the profile (table 1: 4.5 mm).
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
uniform float tap_offset[MAX_TAPS];    // t_i, in units of d' / 2
uniform vec3 tap_weight[MAX_TAPS];     // probability per channel
uniform vec3 depth_factor;             // -1 / 2 s_c^2 per channel

float half_width_px(vec3 x, vec3 n) {
  vec2 xa = vec2(x[axis], x.z);
  vec2 na = vec2(n[axis], n.z);
  float alpha = atan(xa.x, -xa.y);
  float beta = asin(min(r_max_mm / length(xa), 0.999));
  float d = tan(alpha + beta) - tan(alpha - beta);
  float cos_phi = max(dot(na, -xa) / max(length(na) * length(xa), 1e-20), 1e-3);
  return 0.5 * d * cos_phi * focal_px;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  ivec2 size = textureSize(source, 0);
  vec4 center = read_texel(source, p);
  result = center;
  if (center.a > 0.0) {
    vec3 x = read_texel(position, p).xyz;
    float reach_px = half_width_px(x, read_texel(normal, p).xyz);
    vec3 sum = vec3(0.0);
    vec3 weights = vec3(0.0);
    for (int i = 0; i < tap_count; ++i) {
      float offset_px = tap_offset[i] * reach_px;
      int rounded = int(sign(offset_px) * floor(abs(offset_px) + 0.5));
      ivec2 q = p + (axis == 0 ? ivec2(rounded, 0) : ivec2(0, rounded));
      if (!inside(q, size)) continue;
      vec4 tap = read_texel(source, q);
      if (tap.a == 0.0) continue;
      float step_mm = read_texel(position, q).z - x.z;
      vec3 w = tap_weight[i] * exp(step_mm * step_mm * depth_factor);
      sum += w * tap.rgb;
      weights += w;
    }
    // An even number of taps has none at the centre: on a lone pixel all may have been dropped.
    result = vec4(mix(center.rgb, sum / max(weights, vec3(1e-30)), vec3(greaterThan(weights, vec3(1e-30)))), center.a);
  }
  WRITE_COUNTS;
}
