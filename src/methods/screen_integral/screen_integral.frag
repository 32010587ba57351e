// screen-integral: the convolution as an integral over the picture, before any of the filter's approximations
// (Mikkelsen 2010, equations 1-3).
//
// Source: a surface point x(p) is what the ray through p on the plane z = -1 meets first; its area element is
//   dx = w(p) dp,  w(p) = cos^3(phi_i) |x(p)|^2 / cos(phi_j)                                        (2, 3)
// phi_i between the view axis and the ray, phi_j between the ray and the face's normal: an area wants the face's,
// the interpolated one would not tile the surface. For each Gaussian, over every pixel p of skin with
// |x(p) - x_o| <= r_max,
//   M_s(x_o) = sum over p of G(s, |x_o - x(p)|) I(p) w(p) dp                                            (1)
// with exact three-dimensional distances, and w_0 I + sum_i w_i M_i as the result. `sum` = normalised divides each
// Gaussian by its own sum of G w dp. `area` = constant puts w(p_o), of the pixel itself, for w(p): section 5's
// "approximately constant".
//
// What the source leaves open, and what we take: how the integral becomes a sum. A Gaussian that is wider than a
// pixel's footprint is read in its middle, a narrower one is integrated over the footprint, light being constant on
// it (pixel_mean.glsl); so a Gaussian far below a pixel gives the pixel's own light and not a peak. All footprints
// around a pixel have the shape of its own; their areas are their own. The cut-off at r_max is antialiased. Beyond
// 5.5 s no pixel is read.
//
// Settings: r_max_mm (0: the profile's), sum (raw | normalised), area (face | constant).
// Own target: raw, cut off at r_max, over the whole surface. Equation 1 presumes that the surface is all visible, so
//   what is hidden is the method's error; `truth.visible_only` tells it apart.
// Cost: (2 r_px + 1)^2 pixels, two reads each, for every term; r_px = reach times focal over depth, kMostPixels at
//   most.
// Fails: near silhouettes and behind overlaps, where the surface that gives light is hidden (raw: dark; normalised:
//   light of the seen side alone); at faces seen edge on, where w(p) grows beyond what the face has of area (facets
//   smaller than a footprint); light of another surface within r_max, which truth counts as cross-talk.
//
// Limits. Mass (raw): on a plane all but the cut-off is smooth and summed to rounding. The circle's rim cuts no more
// than 4 R (1 / h_u + 1 / h_v) cells of h_u h_v; the ramp that stands for how much of one lies inside is off by at
// most 1/8 (diagonal cut): together R (h_u + h_v) / 2 <= R h times the Gaussian there, h the longer edge. A cut
// cell's middle lies within h / sqrt(2) of the rim, so the Gaussian is at most G(r_max) exp(R h / (sqrt(2) s^2)):
// with h <= s / 2 and R <= 3 s, a factor of 2.9 (beyond 3 s all of it is far smaller). So raw_rim = 3.
// Identity: each Gaussian lies in its own footprint, on which light is constant: only the mass above. Beyond 5.5 s
// lie 3e-7; rounding of some thousand additions of like sign 1e-5 (2^-24 sqrt(2e4) typical). Mirror: the order
// of those additions, 1e-5.
SAMPLER(position);
SAMPLER(face_normal);
SAMPLER(weighted);
uniform float focal_px;
uniform vec3 scale;  // raw: w_i / (2 pi s_i^2) per channel; normalised: w_i

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(0.0);
  if (read_texel(weighted, p).a > 0.0) {
    vec3 x = read_texel(position, p).xyz;
    vec3 n = read_texel(face_normal, p).xyz;
    Footprint footprint = footprint_of(footprint_edge(x, n, 0) / focal_px, footprint_edge(x, n, 1) / focal_px);
    float margin_mm = 0.5 * (length(footprint.u) + length(footprint.v));
    float limit2 = (reach_mm + margin_mm) * (reach_mm + margin_mm);
    vec2 bounds_x = ball_bounds(x, 0, reach_mm) * focal_px;
    vec2 bounds_y = ball_bounds(x, 1, reach_mm) * focal_px;
    ivec2 low = max(p + ivec2(floor(vec2(bounds_x.x, bounds_y.x))), 0);
    ivec2 high = min(p + ivec2(ceil(vec2(bounds_x.y, bounds_y.y))), textureSize(weighted, 0) - 1);
    vec3 sum = vec3(0.0);
    vec3 mass = vec3(0.0);
    for (int qy = low.y; qy <= high.y; ++qy) {
      for (int qx = low.x; qx <= high.x; ++qx) {
        vec4 tap = read_texel(weighted, ivec2(qx, qy));
        if (tap.a == 0.0) continue;
        vec3 d = read_texel(position, ivec2(qx, qy)).xyz - x;
        if (dot(d, d) > limit2) continue;
        vec3 k = pixel_mean(d, footprint);
        sum += k * tap.rgb;
        mass += k * tap.a;
      }
    }
#ifdef NORMALISED
    result = vec4(scale * sum / max(mass, vec3(1e-30)), 0.0);
#else
    float area = 1.0 / (focal_px * focal_px);
#ifdef CONSTANT_AREA
    area *= area_weight(x, n);
#endif
    result = vec4(scale * area * sum, 0.0);
#endif
  }
  WRITE_COUNTS;
}
