// texture-space-transmit: texture-space, and the light that comes through thin parts by translucent shadow maps
// (d'Eon & Luebke 2007, "modified translucent shadow maps"; the walkthrough).
//
// Passes, for each character in view and each light without size that casts shadows:
//   shadow_map.frag    from the light, of the character alone: of what it meets first, the distance z, (u, v), and
//                      whether light gets in
//   uv_thickness.frag  in texture space: the light's irradiance, and exp(-decay t) in alpha, t the thickness; both
//                      are then blurred together, level by level, as texture-space blurs irradiance
//   entry.frag         per pixel: the shadow map's (u, v) there, the entry, and its distance from the pixel's own
//   this one           adds to the level's light at the pixel w_i exp(-t_i^2 / 2 v_i) b_i times level i at the entry,
//                      t_i = -log(alpha) / decay of a level's alpha at the pixel's own uv
// Thickness: t = d mix(1, max(0, -n.l), max(0, -n_e.n)), d = |l| - z the way from the entry to the point along the
// light, n and n_e the interpolated normals at the point and the entry: where they oppose, as on a slab, d cos(theta)
// is what the convolution at the entry wants (a Gaussian parts into exp(-t^2 / 2 v) and itself in the plane). Where
// n.l > 0, where the light meets something else than a transmitter, or nothing, there is no thickness: alpha is 1e-30,
// and what is less than twice that lets nothing through.
// Blend: b_i = min(1, D / (beta sqrt(v_i))), D the distance of point and entry in UV times the mm per unit of uv at
// the point (mean along u and v): what is near along the surface is in the local part already.
// On a slab that is evenly lit from behind the sum is the exact integral, at any angle of the light.
//
// Lights: every light has a map, an irradiance, thicknesses and blurs of its own, so that lights add up; what the
// scene's other lights give (an environment, a light without shadows) is blurred once more, and nothing of it comes
// through. Transmitters are the skin that the scene's `transmitter_mask` marks, without one all of it, read at the
// centroids of triangles: where light goes in. What is not skin casts shadows.
//
// Characters: as in texture-space, one after the other. A light's map has only the character that it is drawn for, and
// is fitted to it: (u, v) of an entry is read in that character's textures, so an entry on another would read light
// that is not there. What another keeps from the light is missing from the irradiance at the entry, and so from what
// comes through, with the edge that blurring gives a shadow; a map of all of them would cut that off at the edge.
//
// Open in the sources, or different, and what we take:
//   The walkthrough reads four thicknesses out of alpha and says nothing of what is written there; d'Eon & Luebke
//   write the above. Both use three of the four, for the three widest Gaussians of six, each Gaussian's out of the
//   level before its own. The walkthrough blends over 0.6 standard deviations, d'Eon & Luebke over 6. Lit points have
//   "a large thickness"; here none. Of several lights d'Eon & Luebke propose textures for each, or the least thickness
//   of all in one; these are the former. Weights are the profile's, not divided by their sum.
//
// Settings: those of texture-space (but for gutter "coverage": alpha holds the thickness), and
//   shadow_map_size         texels a side of the light's picture of a character (1024); read unfiltered
//   transmitting_gaussians  how many of the widest let light through (3). Narrow ones matter below a millimetre only,
//                           where the light is in the local part already
//   thickness               level-before, as in the sources; same-level; unblurred: of the map before any blur
//   normal_correction       on, as in the sources; off: t = d
//   blend_std_devs          beta: 6 (d'Eon & Luebke; the walkthrough: 0.6); 0: b_i = 1
//   decay_per_mm            0.2, as in the sources. Thickness beyond 68 / decay lets nothing through
//
// Own target: texture-space's, geodesic and normalised, and added to it, raw, what the straight way through the body
//   has more than the way along the surface, where that is longer than the profile's r_max.
//
// Measured on the built-in head, six Gaussians, in a picture of the ear alone (experiments/ear.toml has more of the
// head in view, and smaller shares), lit from behind (0.35, 0.25, -1), red, RMSE relative to
// the truth: none 15.3 %, texture-space 7.2 %, this 5.3 %; pscbf 13.4 %, pscbf-transmit 9.7 %. thickness unblurred 7.9
// %, same-level 5.5 %; normal_correction off 5.9 %; blend_std_devs 0.6 6.8 %, 0 6.9 %. Of luminance on average, in
// units of the truth's RMS: transmittance is 0.40 % of the raw truth (truth.light_paths), texture-space lacks 0.30 %
// of the normalised one, and this adds 0.28 %. With all six Gaussians 5.3 % too, but under grazing light, (0.9, 0.25,
// -0.8), seen from the front, from 1.0 to 2.3 % of luminance. Where an ear is lit from both sides, by a point light
// and an environment besides, the normalised truth has nothing to gain, and red goes from 1.4 to 2.1 %.
//
// Fails: averaging exp(-decay t) makes points seem thicker that lie within the kernel's width of others without
//   thickness, at a terminator or a transmitter's edge: by log(1 / share) / decay, 3.5 mm for a half. Level i is read
//   at the entry, t tan(theta) beside the point that faces the exit. Light is added to a local part that is normalised
//   already. Round the terminator of a convex body the way is short and along the surface not much longer, so that
//   light is counted twice; blend_std_devs lessens that, and takes from thin rims what they should have. Distance in
//   UV says little across charts. The entry is the first thing that the light meets, so a gap counts as body. A point
//   light sees nothing that lies more than 80 degrees off the middle of the character, and none of that light comes
//   through. Each light costs a whole diffusion. What texture-space fails by, it fails by too.
//
// Cost for each light and character: texture-space; one pass over its geometry at the shadow map's size; one to find
//   the entry, 8 texels a pixel; 5 texels more for each that has a thickness; and for each transmitting Gaussian two
//   passes, of 6 and up to 6 (bicubic: 18) texels a pixel. Memory beyond texture-space's: 16 bytes a texel of each
//   character's normal map, 20 of the shadow map.
//
// Limits. Constant: a plane that faces its light has no thickness: texture-space's 1e-5. Identity: on a convex body of
// radius of curvature R the entry lies h before the terminator, as the light sees it, and gets h / R of the largest
// irradiance; the exit lies behind the terminator, so t >= h whichever texel of the shadow map is read. So at most
// (h / R) exp(-h^2 / 2 s^2) <= 0.61 s / R comes through: for s below a texel of UV, less than irradiance's change along
// it: within texture-space's. Mirror: the light's picture of the mirrored mesh is the mirror image, texel by texel;
// distances and uv round by 1e-6 of their range, which fades do not enlarge: 1e-5. But a point that lies, to within
// that rounding, on the border of two texels of the shadow map (one in 1e4) may take the other's entry, whose depth is
// off by a texel times the tangent of the light's angle there; the blur dilutes it.
SAMPLER(entry);      // of entry.frag
SAMPLER(thickness);  // r: exp(-decay t)
uniform float decay_per_mm;
uniform float variance_mm2;
uniform float blend_mm;  // 0: no blending
uniform vec3 weight;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(0.0);
  vec4 from = read_texel(entry, p);
  if (from.a > 0.0) {
    float encoded = read_texel(thickness, p).r;
    if (encoded > 2.0 * kNone) {
      float thickness_mm = max(-log(encoded) / decay_per_mm, 0.0);
      float fade = exp(-thickness_mm * thickness_mm / (2.0 * variance_mm2));
      float blend = blend_mm > 0.0 ? min(from.b / blend_mm, 1.0) : 1.0;
      result.rgb = weight * fade * blend * read_level(from.rg).rgb;
    }
  }
  WRITE_COUNTS;
}
