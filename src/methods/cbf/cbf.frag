// cbf: the cross bilateral filter before it is taken apart into two passes (Mikkelsen 2010, equation 8): dense, in
// two dimensions, normalised.
//
// Source: section 5. w(p) is nearly constant within r_max and drops out; the filter is divided by its own weights,
// for the left side of equation 7 is one for I = 1. Each Gaussian at pixel p_o becomes
//   sum over p of g I(p) / sum over p of g,   g = exp(-(K_x^2 dx^2 + K_y^2 dy^2 + dE^2) / 2 s^2)
// over the skin's pixels in the disc of radius r_max in the tangent plane, which is d'_a = d_a cos(phi_a) wide along
// axis a: the ellipse (2 dx / d'_x)^2 + (2 dy / d'_y)^2 <= 1. K, d and the angles: filter_geometry.glsl, with the
// interpolated normal, axis by axis. As K_a d'_a / 2 = r_max cos(theta_a), on a slope along an axis that is the disc.
// One layer, for a disc shrinks to nothing at the silhouette.
//
// What the source leaves open, and what we take: that the region is an ellipse and not the rectangle d'_x d'_y; its
// rim is antialiased, and Gaussians narrower than a pixel are integrated over its footprint (pixel_mean.glsl).
// Sums end 5.5 s from the center.
// `bound` = ball takes K_x^2 dx^2 + K_y^2 dy^2 + dE^2 <= r_max^2 for the disc: the bound d of section 4.
// `spacing` = proportional takes 2 r_max / d'_a in place of K_a: taps at predetermined shares of d'. That is
// K_a / cos(theta_a), the distance along the surface where K_a has that in the XY plane, and dE counts the slope again.
//
// Settings: r_max_mm (0: the profile's), bound (disc | ball), spacing (k | proportional).
// Own target: normalised, cut off at r_max.
// Cost: some (2 r_px + 1)^2 pixels, two reads each, for every term; r_px = reach times focal over depth,
//   kMostPixels at most. The disc reads fewer on slopes.
// Fails: slopes that are not along an axis (the ellipse and K are built from two axes, the disc's picture is a rotated
//   one); curvature (the plane's K); depth gaps below some s (light of another surface); hidden surface; where the
//   interpolated normal looks away from the viewer d' vanishes and no light is scattered.
//
// Limits. Constant: normalised, so to rounding of some thousand additions of like sign, 1e-5. Identity: each Gaussian
// lies in its own footprint, on which light is constant, but for the 3e-7 beyond 5.5 s: 1e-5. Mirror: the order of
// the additions, 1e-5.
uniform vec3 scale;  // w_i per channel

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(0.0);
  vec4 center = read_texel(light, p);
  if (center.a > 0.0) {
    Sums sums = linear_sum(p);
    // Where the disc is far narrower than a cell of the footprint, no sample may have met it.
    vec3 level = mix(center.rgb, sums.light / max(sums.mass, vec3(1e-30)), vec3(greaterThan(sums.mass, vec3(1e-30))));
    result = vec4(scale * level, 0.0);
  }
  WRITE_COUNTS;
}
