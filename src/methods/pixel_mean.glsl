// A Gaussian per channel, exp(-r^2 / 2 s_c^2) cut off at r_max, averaged over a pixel's footprint: the parallelogram
// around `d` (mm, from the filter's centre) that `u` and `v` span. Summed over pixels, times their area, it is the
// convolution.
//
// Where the footprint's edges are at most s / 2, the Gaussian's value in the middle will do: the midpoint rule is off
// by less than rounding (4 exp(-2 pi^2 4)), and only the rim of the cut-off asks for so much. A longer footprint is
// sampled in cells of such edges; where that would take more than kMostCells, only the part within `reach_mm` is
// sampled, beyond which there is nothing to find.
//
// The cut-off is antialiased: a sample counts by clamp(1/2 + (r_max - r) / rim), where `rim` is how far its cell
// extends along the radius, so that the sum changes smoothly and its error cancels around the circle.
uniform vec3 exponent;       // -1 / 2 s_c^2, 1/mm^2
uniform float narrowest_mm;  // the smallest s_c
uniform float reach_mm;      // the smaller of r_max and 5.5 times the largest s_c: beyond it lie 3e-7 of the light
uniform float r_max_mm;

const int kMostCells = 12;
const float kCellsPerStdDev = 2.0;

struct Footprint {
  vec3 u;
  vec3 v;
  ivec2 cells;
  bvec2 clipped;
};

Footprint footprint_of(vec3 u, vec3 v) {
  vec2 edges = vec2(length(u), length(v));
  vec2 cells = ceil(kCellsPerStdDev * edges / narrowest_mm);
  bvec2 clipped = greaterThan(cells, vec2(kMostCells));
  // Within its reach a Gaussian is 11 s wide; the cut through a slanted footprint is longer by 1 / sin.
  float sine = max(length(cross(u, v)) / (edges.x * edges.y), 0.1);
  vec2 within_reach = vec2(min(ceil(kCellsPerStdDev * 2.0 * reach_mm / (narrowest_mm * sine)), 48.0));
  return Footprint(u, v, ivec2(max(mix(cells, within_reach, vec2(clipped)), 1.0)), clipped);
}

#ifdef DISC
// The cut-off is the ellipse of these semi-axes around the centre in the XY plane, in place of the ball of r_max;
// main sets it.
vec2 disc_mm;
#endif

vec3 cut_gaussian(vec3 d, vec3 cell_u, vec3 cell_v) {
#ifdef DISC
  vec2 scaled = d.xy / disc_mm;
  float r = length(scaled);
  vec2 outward = scaled / (disc_mm * max(r, 1e-20));
  float rim = abs(dot(outward, cell_u.xy)) + abs(dot(outward, cell_v.xy));
  float inside_by = 1.0 - r;
#else
  float r = length(d);
  float rim = (abs(dot(d, cell_u)) + abs(dot(d, cell_v))) / max(r, 1e-20);
  float inside_by = r_max_mm - r;
#endif
  return clamp(0.5 + inside_by / max(rim, 1e-20), 0.0, 1.0) * exp(dot(d, d) * exponent);
}

vec3 pixel_mean(vec3 d, Footprint f) {
  if (f.cells == ivec2(1)) return cut_gaussian(d, f.u, f.v);
  vec2 low = vec2(-0.5);
  vec2 high = vec2(0.5);
  if (any(f.clipped)) {
    // The foot of the centre in the pixel's plane, in units of u and v, and the ellipse of the reach around it.
    float uu = dot(f.u, f.u);
    float vv = dot(f.v, f.v);
    float uv = dot(f.u, f.v);
    float du = dot(d, f.u);
    float dv = dot(d, f.v);
    float determinant = max(uu * vv - uv * uv, 1e-12 * uu * vv);
    vec2 foot = vec2(dv * uv - du * vv, du * uv - dv * uu) / determinant;
    float height2 = dot(d, d) + foot.x * du + foot.y * dv;
    vec2 half_range = sqrt(max(reach_mm * reach_mm - height2, 0.0) * vec2(vv, uu) / determinant);
    low = mix(low, max(low, foot - half_range), vec2(f.clipped));
    high = mix(high, min(high, foot + half_range), vec2(f.clipped));
    if (any(lessThanEqual(high, low))) return vec3(0.0);
  }
  vec2 cell = (high - low) / vec2(f.cells);
  vec3 cell_u = cell.x * f.u;
  vec3 cell_v = cell.y * f.v;
  vec3 first = d + (low.x + 0.5 * cell.x) * f.u + (low.y + 0.5 * cell.y) * f.v;
  vec3 sum = vec3(0.0);
  for (int j = 0; j < f.cells.y; ++j) {
    for (int i = 0; i < f.cells.x; ++i)
      sum += cut_gaussian(first + float(i) * cell_u + float(j) * cell_v, cell_u, cell_v);
  }
  return cell.x * cell.y * sum;
}
