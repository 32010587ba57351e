// cbf-unnormalised: the convolution as an unnormalised cross bilateral filter (Mikkelsen 2010, equations 4-7, with
// K axis by axis as section 4 has it), over one layer of the surface or several.
//
// Source: with the area weight premultiplied, I~(p) = I(x(p)) w(p) (4, 2; the face's normal, see screen_integral.frag),
// depth E (5) and |r_12| = K |p - p_o| (6), each Gaussian at p_o is
//   2 pi s^2 / (K_x K_y) * sum over p of G(s / K_x, s / K_y; p - p_o) G(s, |E(p) - E(p_o)|) I~(p) dp       (7)
// where G(s / K_x, s / K_y; dx, dy) = K_x K_y / (2 pi s^2) exp(-(K_x^2 dx^2 + K_y^2 dy^2) / 2 s^2). The two Gaussians'
// factors and the prefactor leave 1 / (2 pi s^2), which `scale` has. K_a = 2 r_max cos(theta) / (d_a cos(phi)) in the
// (a, z) plane, by the interpolated normal (filter_geometry.glsl). Only what lies within r_max counts, by the same
// distances: K_x^2 dx^2 + K_y^2 dy^2 + dE^2 <= r_max^2, inside the picture d of the ball (figure 2).
// Layers: depth peeling; equation 7 is summed over all. Layer 1 is what is seen, layer l + 1 the nearest surface behind
// layer l, whichever way it faces. `layers` = 1..8.
//
// What the source leaves open, and what we take: the sum's quadrature (pixel_mean.glsl: Gaussians narrower than
// a pixel are integrated over its footprint in K's metric, the rim of the cut-off is antialiased; sums end 5.5 s from
// the center); K at a pixel of another layer is that of the center, as in equation 6. Surfaces nearer to each other
// along a ray than 4e-6 of their depth are one layer.
//
// Settings: r_max_mm (0: the profile's), layers.
// Own target: raw, cut off at r_max, over the whole surface: what no layer holds is the method's error.
// Cost: for every layer beyond the first two passes over the geometry; for every layer and term (2 r_px + 1)^2 pixels,
//   two reads each; r_px = reach times focal over depth, kMostPixels at most.
// Fails: hidden surface (one layer: dark bands behind overlaps and at silhouettes; more layers: only faces seen edge
//   on, which no pixel meets); slopes not along an axis and curvature (K is a plane's, built from two axes), which
//   here change the mass, and that is brightness; faces of which a pixel sees less than w(p) says; where the
//   interpolated normal looks away from the viewer K is huge and light is lost.
//
// Limits. Mass and identity as in screen_integral.frag, raw_rim = 3, and what K adds, raw_perspective: by equation 2
// the true footprint is w n = z^2 z n / (n . x); (K_x, 0, e_x) x (0, K_y, e_y), with K_a = z^2 n_z / (x_a n_a + z n_z)
// and e_a the true change of depth, differs from it by the relative amount n_x n_y (n_x y + n_y x) / (z n_z) to
// first order: none on the picture's axes, at most sin^2(theta) tan(theta) / 2 times the tangent of the angle from
// the view axis elsewhere. And d is wider than 2 r_max / D by (r_max / D)^2 / 2, on a slope times 1 / cos^2(theta),
// so that K_x K_y is off by twice that. 1.25 times the sum of the two, for what is of higher order.
SAMPLER(center_light);  // of the first layer
uniform vec3 scale;     // w_i / (2 pi s_i^2) per channel

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(0.0);
  if (read_texel(center_light, p).a > 0.0)
    result = vec4(scale / (focal_px * focal_px) * linear_sum(p).light, 0.0);
  WRITE_COUNTS;
}
