// pscbf-transmit: pscbf, and the light that comes through thin parts (Mikkelsen 2010, section 6).
//
// Source: back-facing primitives are drawn into a second, back buffer, only those of transmitters (a mask marks them);
// their irradiance is integrated within d' by 16 taps, accumulated as by d'Eon & Luebke (2007), who fade a Gaussian's
// light by exp(-thickness^2 / 2 v); the tangent planes at x_o and at the transmitting point x_t must be opposing, and a
// contribution is scaled by sqrt(max(0, -n_t . n_o)), with interpolated normals.
//
//   result = pscbf + sum over Gaussians i of w_i T_i,
//   T_i = sum over 16 taps t of p_t sqrt(max(0, -n_t . n_o)) exp(-(E_t - E_o)^2 / 2 s_i^2) I_t,
//
// E being the view-space depth, I_t and n_t read from the back buffer, and I_t 0 where that is empty.
//
// Open in the source, and what we take: the taps are 4 x 4, each axis 4 taps of equal probability under red's Gaussian
// laid over d'_a as pscbf lays its own, p_t the product of the axes' weights, green's and blue's corrected likewise;
// p_t sum to 1 and T_i is not divided by what its taps weigh, for where nothing is behind nothing comes through; the
// fade is equation 8's depth term, so that a slab that faces the camera has T_i = exp(-t^2 / 2 s_i^2) I, the exact
// integral; it is added to all Gaussians of the profile (d'Eon & Luebke: to the wide ones); the nearest of several back
// faces is kept.
//
// Settings: those of pscbf, for the local part; placement and r_max_mm serve these taps too. Transmitters are the skin that
//   the scene's `transmitter_mask` marks, without one all of it; the mask is read at the centroids of triangles.
// Own target: the local filter's, Euclidean and normalised over what lies within r_max along the surface, and added to
//   it, raw, the light from farther along the surface whose straight way lies inside the body. All skin lets light
//   through there: the transmitters' mask is the method's saving.
// Cost: pscbf, two passes over the geometry, and one of up to 3 + 16 * 2 reads for each Gaussian.
// Fails: thickness is taken along the view, so a slab seen at an angle theta seems 1 / cos(theta) thicker, and the
//   taps' depths spread by s sin(theta): T = exp(-a^2 / 2 b^2) / b with a = t / (s cos(theta)), b^2 = 1 +
//   sin(theta)^2; its light is added to a local part that is already normalised, so thin lit parts are too bright:
//   evenly lit, a slab of thickness t sends back 1 + exp(-t^2 / 2 s^2) of the light; 4 medians an axis have 0.712 s^2
//   of the variance, so light behind is blurred too little; back faces behind the first are not seen; light that
//   comes sideways through an edge is missed, whose planes do not oppose.
//
// Limits. Constant: on an open plane there is no back face: pscbf's own 1e-6. Identity: a body is thick against narrow
// Gaussians, T = 0: 1e-6. Mirror: taps are symmetric, rounded away from the centre alike: pscbf's 1e-5.
SAMPLER(local);         // pscbf's result
SAMPLER(position);
SAMPLER(normal);
SAMPLER(irradiance);
SAMPLER(back_surface);
SAMPLER(back_light);
uniform float local_weight;          // 1 in the first pass, 0 in those that add to it
uniform float r_max_mm;
uniform float focal_px;
uniform float tap_offset[TAPS];      // t_i, in units of d' / 2
uniform vec3 tap_weight[TAPS];
uniform vec3 depth_factor;           // -1 / 2 s_c^2 per channel
uniform vec3 weight;

ivec2 rounded(vec2 offset_px) { return ivec2(sign(offset_px) * floor(abs(offset_px) + 0.5)); }

vec3 transmitted(ivec2 p) {
  vec3 x = read_texel(position, p).xyz;
  vec3 n = read_texel(normal, p).xyz;
  vec2 reach_px = focal_px * vec2(disc_half_extent(x, n, 0, r_max_mm), disc_half_extent(x, n, 1, r_max_mm));
  vec3 sum = vec3(0.0);
  for (int j = 0; j < TAPS; ++j) {
    for (int i = 0; i < TAPS; ++i) {
      ivec2 q = p + rounded(vec2(tap_offset[i], tap_offset[j]) * reach_px);
      if (!inside(q, textureSize(back_light, 0))) continue;
      vec4 light = read_texel(back_light, q);
      if (light.a == 0.0) continue;
      vec4 surface = read_texel(back_surface, q);
      float opposing = sqrt(max(0.0, -dot(surface.xyz, n)));
      float step_mm = surface.a - x.z;
      sum += opposing * tap_weight[i] * tap_weight[j] * exp(step_mm * step_mm * depth_factor) * light.rgb;
    }
  }
  return sum;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = local_weight > 0.0 ? read_texel(local, p) : vec4(0.0);
  if (read_texel(irradiance, p).a > 0.0) result.rgb += weight * transmitted(p);
  WRITE_COUNTS;
}
