// The geometry of a filter that a ball of radius r_max around the pixel's point bounds (Mikkelsen 2010, figure 2;
// section 4). View space, mm: the observer at the origin, the picture on the plane z = -1, where a pixel's edge
// is 1 / focal_px. With (x_a, z) of the point along axis a, alpha its angle from the view axis and D its distance:
//
//   sin(beta) = r_max / D,   bounds tan(alpha -+ beta) - tan(alpha),   d_a = tan(alpha + beta) - tan(alpha - beta)
//
// all written without angles, for that loses no digits where r_max is far below D.
const float kSmallestCosine = 1e-3;

vec2 along(vec3 v, int axis) { return vec2(v[axis], v.z); }

// From the point's own picture to the two ends of the ball's, along `axis`, on the plane z = -1. A ball that
// reaches beside or behind the observer ends at some 87 degrees.
vec2 ball_bounds(vec3 x, int axis, float radius_mm) {
  vec2 xa = along(x, axis);
  float distance_mm = length(xa);
  float sin_alpha = xa.x / distance_mm;
  float cos_alpha = max(-xa.y / distance_mm, 0.05);
  float sin_beta = min(radius_mm / distance_mm, 0.999);
  float cos_beta = sqrt(1.0 - sin_beta * sin_beta);
  vec2 cosines = max(cos_alpha * cos_beta + vec2(1.0, -1.0) * sin_alpha * sin_beta, 0.05);
  return vec2(-1.0, 1.0) * sin_beta / (cosines * cos_alpha);
}

// cos(theta) = |n_a.z| and cos(phi) = n_a . omega_a, with the (a, z) parts of the normal and of the direction to
// the viewer, renormalised. cos(phi) is kSmallestCosine at least.
vec2 axis_cosines(vec3 x, vec3 n, int axis) {
  vec2 xa = along(x, axis);
  vec2 na = along(n, axis);
  na /= max(length(na), 1e-20);
  return vec2(abs(na.y), max(dot(na, -xa) / max(length(xa), 1e-20), kSmallestCosine));
}

// K_a = 2 r_max cos(theta) / (d_a cos(phi)): mm in the XY plane per unit of the plane z = -1.
float linear_scale(vec3 x, vec3 n, int axis, float r_max_mm) {
  vec2 bounds = ball_bounds(x, axis, r_max_mm);
  vec2 cosines = axis_cosines(x, n, axis);
  return 2.0 * r_max_mm * cosines.x / ((bounds.y - bounds.x) * cosines.y);
}

// Half the extent of the disc of radius r_max in the tangent plane, d'_a / 2 = d_a cos(phi) / 2, on z = -1.
float disc_half_extent(vec3 x, vec3 n, int axis, float r_max_mm) {
  vec2 bounds = ball_bounds(x, axis, r_max_mm);
  return 0.5 * (bounds.y - bounds.x) * axis_cosines(x, n, axis).y;
}

// n . x, kept from 0: a face seen at a grazing angle has a large footprint, not an infinite one.
float safe_dot(vec3 n, vec3 x) {
  float nx = dot(n, x);
  float least = kSmallestCosine * length(x);
  return nx < 0.0 ? min(nx, -least) : max(nx, least);
}

// Where the plane of normal n through x moves per unit of the picture along `axis`: the derivative of the ray's
// point on it, -z (e_a - x n_a / (n . x)). The two have the vector product w(p) n.
vec3 footprint_edge(vec3 x, vec3 n, int axis) {
  vec3 e = axis == 0 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
  return -x.z * (e - x * (n[axis] / safe_dot(n, x)));
}

// Equation 2: w(p) = cos^3(phi_i) |x|^2 / cos(phi_j), the area in mm^2 that a unit of the picture covers; n is the
// face's normal. cos(phi_i) = -z / |x|; the face may look away (a deeper layer), so |cos(phi_j)|.
float area_weight(vec3 x, vec3 n) {
  float cos_i = -x.z / length(x);
  return cos_i * cos_i * cos_i * dot(x, x) * length(x) / abs(safe_dot(n, x));
}
