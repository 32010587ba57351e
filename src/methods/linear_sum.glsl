// The sum over pixels of Mikkelsen's equations 5 to 7 around the pixel p: with K_a of filter_geometry.glsl, a pixel
// q lies at (K_x dx, K_y dy, dE) from it, dx and dy on the plane z = -1 and E the depth. A pixel's footprint has the
// edges K_a / focal_px there and, in depth, the slope of the center's face. With PROPORTIONAL it is K_a / cos(theta).
SAMPLER(position);
SAMPLER(normal);
SAMPLER(face_normal);
SAMPLER(tap_position);  // of the layer that gives light
SAMPLER(light);         // of that layer: rgb times a weight, the weight in a, 0 off the skin
uniform float focal_px;

struct Sums {
  vec3 light;
  vec3 mass;
};

Sums linear_sum(ivec2 p) {
  vec3 x = read_texel(position, p).xyz;
  vec3 n = read_texel(normal, p).xyz;
  vec3 face = read_texel(face_normal, p).xyz;
  vec2 k = vec2(linear_scale(x, n, 0, r_max_mm), linear_scale(x, n, 1, r_max_mm));
#ifdef DISC
  disc_mm = max(r_max_mm * vec2(axis_cosines(x, n, 0).x, axis_cosines(x, n, 1).x), 1e-6 * r_max_mm);
#endif
#ifdef PROPORTIONAL
  k = r_max_mm / vec2(disc_half_extent(x, n, 0, r_max_mm), disc_half_extent(x, n, 1, r_max_mm));
#ifdef DISC
  disc_mm = vec2(r_max_mm);
#endif
#endif
  vec2 step_mm = k / focal_px;
  Footprint footprint = footprint_of(vec3(step_mm.x, 0.0, footprint_edge(x, face, 0).z / focal_px),
                                     vec3(0.0, step_mm.y, footprint_edge(x, face, 1).z / focal_px));
  float margin_mm = 0.5 * (length(footprint.u) + length(footprint.v));
  float limit2 = (reach_mm + margin_mm) * (reach_mm + margin_mm);
  vec2 bounds_x = ball_bounds(x, 0, reach_mm) * focal_px;
  vec2 bounds_y = ball_bounds(x, 1, reach_mm) * focal_px;
  vec2 first = floor(vec2(bounds_x.x, bounds_y.x));
  vec2 last = ceil(vec2(bounds_x.y, bounds_y.y));
#ifdef DISC
  vec2 half_px = ceil(disc_mm / step_mm);
  first = max(first, -half_px);
  last = min(last, half_px);
#endif
  ivec2 low = max(p + ivec2(first), 0);
  ivec2 high = min(p + ivec2(last), textureSize(light, 0) - 1);
  Sums sums = Sums(vec3(0.0), vec3(0.0));
  for (int qy = low.y; qy <= high.y; ++qy) {
    for (int qx = low.x; qx <= high.x; ++qx) {
      ivec2 q = ivec2(qx, qy);
      vec2 in_plane = vec2(q - p) * step_mm;
      if (dot(in_plane, in_plane) > limit2) continue;
      vec4 tap = read_texel(light, q);
      if (tap.a == 0.0) continue;
      vec3 weight = pixel_mean(vec3(in_plane, read_texel(tap_position, q).z - x.z), footprint);
      sums.light += weight * tap.rgb;
      sums.mass += weight * tap.a;
    }
  }
  return sums;
}
