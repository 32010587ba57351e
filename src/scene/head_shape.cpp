#include "scene/head_shape.h"

#include <array>
#include <vector>

#include "scene/head_sculpt.h"

// The bust, about 0.7 of life, in the order in which a sculptor builds it up: the masses of skull, jaw and
// neck; the planes of the face; then nose, eyes, mouth and ears. x points to the bust's left, y up, z to
// where it looks. Everything is modelled for x > 0 and mirrored.
namespace truescatter {
namespace {

using namespace sculpt;

// The union with a sweep, skipped where that is too far away to matter.
double with_sweep(double d, const Sweep& sweep, const Vec3d& p, double k_mm) {
  return sweep.far_bound_mm(p) > std::abs(d) + k_mm ? d : smooth_union(d, sweep.distance_mm(p), k_mm);
}

// --- Lofts: bodies that are given by their outlines ---

// One horizontal section: how far it reaches to the front and back, where it is widest, and half its width.
struct Section {
  double front_mm;
  double back_mm;
  double widest_z_mm;
  double half_width_mm;
  double exponent;  // of the superellipse's front half: 2 is an ellipse, more is boxier
};

Section blend(const Section& a, double wa, const Section& b, double wb) {
  return {wa * a.front_mm + wb * b.front_mm, wa * a.back_mm + wb * b.back_mm,
          wa * a.widest_z_mm + wb * b.widest_z_mm, wa * a.half_width_mm + wb * b.half_width_mm,
          wa * a.exponent + wb * b.exponent};
}

double superellipse_norm(double x, double z, double n) {
  constexpr double kTiny = 1e-12;  // keeps the axis differentiable
  if (n == 2.0) return std::sqrt(x * x + z * z + kTiny);
  return std::pow(std::pow(x, n) + std::pow(z, n) + kTiny, 1.0 / n);
}

// Sections every 10 mm, joined by a uniform cubic B-spline, with rounded caps.
struct Loft {
  double lowest_mm;  // y of the first section
  std::vector<Section> sections;
  double bottom_mm;  // below this the body closes within bottom_cap_mm, likewise above top_mm
  double bottom_cap_mm;
  double top_mm;
  double top_cap_mm;

  Section at(double y) const {
    const double last = double(sections.size()) - 4.0;
    const double s = std::clamp((y - lowest_mm) / 10.0 - 1.0, 0.0, last + 1.0 - 1e-9);
    const std::size_t i = std::size_t(s);
    const double t = s - double(i);
    const double t2 = t * t, t3 = t2 * t;
    const Section ab =
        blend(sections[i], (1 - 3 * t + 3 * t2 - t3) / 6, sections[i + 1], (4 - 6 * t2 + 3 * t3) / 6);
    const Section cd = blend(sections[i + 2], (1 + 3 * t + 3 * t2 - 3 * t3) / 6, sections[i + 3], t3 / 6);
    return blend(ab, 1.0, cd, 1.0);
  }

  double distance_mm(const Vec3d& p) const {
    constexpr double kEase_mm = 16.0;  // the caps set in gently
    const double y = smooth_intersection(smooth_union(p.y(), top_mm, kEase_mm), bottom_mm, kEase_mm);
    const Section section = at(y);
    const bool is_front = p.z() > section.widest_z_mm;
    const double depth_mm =
        is_front ? section.front_mm - section.widest_z_mm : section.widest_z_mm - section.back_mm;
    const double n = is_front ? section.exponent : 2.0;
    const double z = p.z() - section.widest_z_mm;
    const double planar =
        superellipse_norm(std::abs(p.x()) / section.half_width_mm, std::abs(z) / depth_mm, n);
    const double rise_mm = p.y() - y;
    const double cap = rise_mm / (rise_mm > 0.0 ? top_cap_mm : bottom_cap_mm);
    const double q = std::sqrt(planar * planar + cap * cap);
    return std::sqrt(p.x() * p.x() + z * z + rise_mm * rise_mm) * (1.0 - 1.0 / q);
  }
};

// Cranium, face and jaw, without what sticks out or is let in later.
Loft head_loft() {
  Loft loft;
  loft.lowest_mm = -90.0;
  //                 front  back widest width exponent
  loft.sections = {{61.0, 26.0, 40.0, 19.0, 2.0},     // -90
                   {62.0, 24.0, 38.0, 20.0, 2.0},     // -80
                   {63.0, 18.0, 34.0, 22.0, 2.0},     // -70: chin
                   {64.0, 6.0, 24.0, 27.0, 2.0},      // -60
                   {62.5, -8.0, 10.0, 32.0, 2.0},     // -50
                   {63.5, -24.0, 0.0, 37.0, 2.0},     // -40: mouth
                   {64.0, -42.0, -6.0, 41.5, 2.05},   // -30
                   {62.5, -56.0, -9.0, 47.0, 2.1},    // -20
                   {61.0, -65.0, -10.0, 49.0, 2.15},  // -10
                   {60.5, -70.0, -10.0, 50.0, 2.2},   //   0
                   {61.5, -72.5, -10.0, 51.0, 2.25},  //  10: eyes
                   {64.0, -74.0, -10.0, 52.5, 2.3},   //  20: brow
                   {65.0, -74.0, -11.0, 54.0, 2.25},  //  30
                   {64.0, -73.0, -12.0, 55.0, 2.2},   //  40
                   {63.0, -72.0, -12.0, 55.0, 2.15},  //  50
                   {62.0, -72.0, -12.0, 55.0, 2.1}};  //  60
  loft.bottom_mm = -57.0;
  loft.bottom_cap_mm = 12.0;
  loft.top_mm = 40.0;
  loft.top_cap_mm = 54.0;
  return loft;
}

Loft neck_loft() {
  Loft loft;
  loft.lowest_mm = -130.0;
  loft.sections = {{19.0, -70.0, -24.0, 47.0, 2.0},   // -130
                   {19.0, -69.0, -23.0, 45.0, 2.0},   // -120
                   {19.5, -65.0, -22.0, 41.5, 2.0},   // -110
                   {21.0, -61.0, -20.0, 38.0, 2.0},   // -100
                   {23.0, -57.5, -18.0, 35.5, 2.0},   // -90
                   {25.5, -55.0, -16.0, 34.0, 2.0},   // -80
                   {28.0, -53.5, -14.0, 33.5, 2.0},   // -70
                   {29.0, -53.0, -13.0, 34.0, 2.0},   // -60
                   {29.0, -53.0, -13.0, 35.0, 2.0},   // -50
                   {28.0, -53.0, -13.0, 36.0, 2.0},   // -40
                   {26.0, -54.0, -13.0, 36.0, 2.0},   // -30
                   {26.0, -54.0, -13.0, 36.0, 2.0}};  // -20
  loft.bottom_mm = -200.0;                            // the base cuts it off
  loft.bottom_cap_mm = 10.0;
  loft.top_mm = -30.0;
  loft.top_cap_mm = 25.0;
  return loft;
}

// --- The ear's frame ---

constexpr double kDegree = kPi / 180.0;

// Ear coordinates: forward, up, and outward from the skull.
struct EarFrame {
  Vec3d origin_mm{53.5, 0.0, -11.0};
  Vec3d forward;
  Vec3d up;
  Vec3d outward;

  EarFrame() {
    const double lean = 12.0 * kDegree;   // the top leans back
    const double flare = 22.0 * kDegree;  // the rear edge stands off the skull
    const Vec3d level_forward(0.0, std::sin(lean), std::cos(lean));
    up = Vec3d(0.0, std::cos(lean), -std::sin(lean));
    forward = std::cos(flare) * level_forward - std::sin(flare) * Vec3d::UnitX();
    outward = std::cos(flare) * Vec3d::UnitX() + std::sin(flare) * level_forward;
  }
  Vec3d to_local(const Vec3d& p) const {
    const Vec3d d = p - origin_mm;
    return {d.dot(forward), d.dot(up), d.dot(outward)};
  }
};

constexpr double kEarReach_mm = 36.0;  // the ear lies within this of its origin

// --- The bust ---

class Bust {
 public:
  Bust() {
    model_nose();
    model_eye();
    model_mouth();
    model_folds();
    model_ear();
  }

  double distance_mm(const Vec3d& p) const {
    const Vec3d half = fold(p);
    return with_ear(earless_mm(half), half);
  }

  HeadPart part(const Vec3d& p) const;

 private:
  // Mirrors to x > 0; the rounding keeps what crosses the middle smooth.
  static Vec3d fold(const Vec3d& p, double rounding_mm = 0.2) {
    return {std::sqrt(p.x() * p.x() + rounding_mm * rounding_mm), p.y(), p.z()};
  }

  // True where a feature inside a ball cannot matter to a body at distance d, at a rounding of k_mm.
  static bool is_out_of_reach(const Vec3d& p, const Vec3d& center_mm, double radius_mm, double d,
                              double k_mm) {
    return (p - center_mm).norm() - radius_mm > std::abs(d) + k_mm;
  }

  void model_nose();
  void model_eye();
  void model_mouth();
  void model_folds();
  void model_ear();

  double masses_mm(const Vec3d& p) const;
  double with_cheek_and_chin(double d, const Vec3d& p) const;
  double with_nose(double d, const Vec3d& p) const;
  double with_eye(double d, const Vec3d& p) const;
  double with_mouth(double d, const Vec3d& p) const;
  double with_neck(double d, const Vec3d& p) const;
  double with_ear(double d, const Vec3d& p) const;
  double face_mm(const Vec3d& p) const { return with_nose(with_cheek_and_chin(masses_mm(p), p), p); }
  double earless_mm(const Vec3d& p) const { return with_neck(with_mouth(with_eye(face_mm(p), p), p), p); }

  // The knot of a curve that is laid onto the face: x and y as seen from the front, and how far it is lifted.
  struct FaceKnot {
    double x_mm;
    double y_mm;
    double lift_mm;
    double radius_mm;
  };
  template <typename Field>
  static Sweep drape(const std::vector<FaceKnot>& knots, const Field& field);

  Loft head_ = head_loft();
  Loft neck_ = neck_loft();
  Sweep nose_bridge_;
  Sweep wing_groove_;
  Sweep upper_lid_fold_;
  Sweep lid_line_;
  Sweep lower_lid_fold_;
  Sweep upper_lip_;
  Sweep lower_lip_;
  Sweep mouth_line_;
  Sweep nasolabial_fold_;
  Sweep neck_muscle_;
  Sweep helix_;
  Sweep antihelix_;
  Sweep antihelix_fork_;
  Sweep scapha_;
  EarFrame ear_;
};

// Finds the skin from the front and puts each knot onto it.
template <typename Field>
Sweep Bust::drape(const std::vector<FaceKnot>& knots, const Field& field) {
  std::vector<Knot> on_skin;
  for (const FaceKnot& knot : knots) {
    Vec3d p(knot.x_mm, knot.y_mm, 100.0);
    for (int step = 0; step < 400; ++step) p.z() -= 0.5 * field(fold(p));
    on_skin.push_back({p + Vec3d(0.0, 0.0, knot.lift_mm), knot.radius_mm});
  }
  return Sweep(on_skin);
}

double Bust::masses_mm(const Vec3d& p) const {
  const double head = head_.distance_mm(p);
  constexpr double kBlend_mm = 16.0;
  const double above_neck_mm = p.y() - (neck_.top_mm + neck_.top_cap_mm);
  if (above_neck_mm > std::abs(head) + kBlend_mm) return head;
  return smooth_union(head, neck_.distance_mm(p), kBlend_mm);
}

double Bust::with_cheek_and_chin(double d, const Vec3d& p) const {
  const Vec3d soft = fold(p, 4.0);
  // Cheekbones, the mound of the teeth, the chin's ball, the angle of the jaw.
  d = smooth_union(d, Ellipsoid{{26.5, -6.0, 35.0}, {14.5, 12.0, 14.0}}.distance_mm(soft), 20.0);
  d = smooth_union(d, Ellipsoid{{22.0, -22.0, 34.0}, {15.0, 20.0, 15.0}}.distance_mm(soft), 20.0);
  d = smooth_union(d, Ellipsoid{{0.0, -37.0, 44.0}, {24.0, 17.0, 24.0}}.distance_mm(p), 14.0);
  d = smooth_union(d, Ellipsoid{{0.0, -59.0, 53.0}, {15.0, 9.0, 12.5}}.distance_mm(p), 12.0);
  d = smooth_union(d, Capsule{{31.5, -40.0, 2.0}, 7.0, {13.5, -58.0, 44.0}, 7.0}.distance_mm(soft), 18.0);
  // The brow ridge, and the temple behind it.
  d = smooth_union(d, Capsule{{8.0, 20.5, 56.5}, 7.0, {29.0, 23.0, 43.5}, 6.0}.distance_mm(soft), 16.0);
  d += 2.0 * Ellipsoid{{50.0, 24.0, 30.0}, {20.0, 24.0, 24.0}}.brush(soft);
  return d;
}

void Bust::model_nose() {
  nose_bridge_ = Sweep({{{0.0, 18.0, 56.0}, 6.5},
                        {{0.0, 9.0, 57.5}, 5.5},
                        {{0.0, 0.0, 62.0}, 5.2},
                        {{0.0, -9.0, 68.0}, 5.4},
                        {{0.0, -15.0, 72.5}, 6.2}});
  wing_groove_ = Sweep({{{7.5, -9.5, 72.5}, 2.0},
                        {{11.6, -13.0, 67.0}, 2.6},
                        {{13.5, -18.0, 63.2}, 3.0},
                        {{13.3, -24.0, 60.5}, 2.5}});
}

double Bust::with_nose(double d, const Vec3d& p) const {
  if (is_out_of_reach(p, {0.0, -4.0, 66.0}, 31.0, d, 13.0)) return d;
  d = with_sweep(d, nose_bridge_, p, 13.0);
  d = smooth_union(d, Ellipsoid{{0.0, -16.5, 73.5}, {7.4, 6.4, 7.2}}.distance_mm(p), 8.0);  // tip
  d = smooth_union(d, Ellipsoid{{8.2, -18.8, 68.0}, {5.0, 5.2, 7.0}}.distance_mm(p), 7.0);  // wing
  d = smooth_union(d, Capsule{{0.0, -20.0, 73.0}, 2.8, {0.0, -24.0, 64.5}, 3.2}.distance_mm(p),
                   4.0);  // columella
  d += 0.28 * wing_groove_.groove_mm(p);
  const Ellipsoid nostril{{5.2, -22.0, 68.8}, {2.6, 6.6, 4.4}};
  return smooth_difference(d, nostril.distance_mm(p), 2.4);
}

void Bust::model_eye() {
  const auto lidded = [this](const Vec3d& p) { return with_eye(face_mm(p), p); };
  const std::vector<FaceKnot> upper = {{10.5, 8.0, 0.0, 2.0},
                                       {14.5, 13.2, 0.0, 2.3},
                                       {22.0, 16.0, 0.0, 2.6},
                                       {29.5, 13.8, 0.0, 2.4},
                                       {36.0, 7.5, 0.0, 2.0}};
  const std::vector<FaceKnot> line = {{8.5, 6.4, 0.0, 1.8},
                                      {14.0, 5.2, 0.0, 2.0},
                                      {21.5, 3.8, 0.0, 2.2},
                                      {29.0, 5.0, 0.0, 2.0},
                                      {36.0, 8.6, 0.0, 1.8}};
  const std::vector<FaceKnot> lower = {
      {10.0, 2.0, 0.0, 3.0}, {15.5, -3.0, 0.0, 4.0}, {23.0, -5.0, 0.0, 5.0}, {34.0, -1.0, 0.0, 3.5}};
  const Sweep upper_fold = drape(upper, lidded);
  const Sweep lid_line = drape(line, lidded);
  const Sweep lower_fold = drape(lower, lidded);
  upper_lid_fold_ = upper_fold;
  lid_line_ = lid_line;
  lower_lid_fold_ = lower_fold;
}

double Bust::with_eye(double d, const Vec3d& p) const {
  if (is_out_of_reach(p, {22.0, 8.0, 55.0}, 22.0, d, 9.0)) return d;
  const Ellipsoid socket{{22.0, 8.5, 62.0}, {15.0, 10.0, 11.0}};
  const Ellipsoid ball{{22.0, 7.5, 45.2}, {11.3, 10.3, 10.8}};
  d = smooth_difference(d, socket.distance_mm(p), 9.0);
  d = smooth_union(d, ball.distance_mm(p), 2.5);
  d += 0.36 * upper_lid_fold_.groove_mm(p) + 0.4 * lid_line_.groove_mm(p) +
       0.06 * lower_lid_fold_.groove_mm(p);
  return d;
}

void Bust::model_mouth() {
  const auto bare = [this](const Vec3d& p) { return face_mm(p); };
  upper_lip_ = drape({{-4.5, -34.6, -1.2, 3.0},
                      {0.0, -35.4, -1.0, 2.9},
                      {4.5, -34.6, -1.2, 3.0},
                      {10.5, -36.2, -1.4, 2.6},
                      {14.5, -37.6, -1.8, 1.9},
                      {18.0, -39.2, -2.8, 1.0}},
                     bare);
  lower_lip_ = drape({{-6.0, -41.6, -1.6, 3.7},
                      {0.0, -41.8, -1.6, 3.7},
                      {6.0, -41.6, -1.6, 3.7},
                      {11.5, -40.8, -1.8, 2.9},
                      {15.0, -40.2, -2.0, 1.9},
                      {18.0, -39.4, -2.8, 1.0}},
                     bare);
  const auto lipped = [this](const Vec3d& p) { return with_mouth(face_mm(p), p); };
  mouth_line_ = drape({{-5.0, -37.9, 0.0, 1.9},
                       {0.0, -38.3, 0.0, 1.9},
                       {5.0, -37.8, 0.0, 1.9},
                       {11.0, -38.5, 0.0, 1.8},
                       {15.0, -38.9, 0.0, 2.2},
                       {21.0, -40.4, 0.0, 2.0}},
                      lipped);
}

double Bust::with_mouth(double d, const Vec3d& p) const {
  if (is_out_of_reach(p, {0.0, -37.0, 62.0}, 35.0, d, 3.0)) return d;
  d += 1.0 * Ellipsoid{{0.0, -30.0, 70.0}, {3.2, 6.0, 6.0}}.brush(p);    // philtrum
  d += 2.0 * Ellipsoid{{0.0, -49.5, 68.0}, {15.0, 6.0, 10.0}}.brush(p);  // furrow above the chin
  d += 0.09 * nasolabial_fold_.groove_mm(p);
  if (upper_lip_.far_bound_mm(p) < 6.0 || lower_lip_.far_bound_mm(p) < 6.0) {
    d = with_sweep(d, upper_lip_, p, 2.2);
    d = with_sweep(d, lower_lip_, p, 2.2);
    d += 0.55 * mouth_line_.groove_mm(p);
  }
  return d;
}

void Bust::model_folds() {
  const auto bare = [this](const Vec3d& p) { return face_mm(p); };
  nasolabial_fold_ = drape(
      {{15.0, -17.0, 0.0, 3.5}, {17.5, -24.0, 0.0, 5.5}, {21.0, -32.0, 0.0, 6.5}, {25.0, -44.0, 0.0, 5.0}},
      bare);
  neck_muscle_ = Sweep({{{35.5, -24.0, -21.0}, 4.0},
                        {{31.5, -55.0, -8.0}, 5.5},
                        {{20.0, -85.0, 7.0}, 5.0},
                        {{8.0, -110.0, 15.0}, 3.5}});
}

double Bust::with_neck(double d, const Vec3d& p) const {
  if (p.y() > 0.0) return d;
  d = with_sweep(d, neck_muscle_, p, 10.0);
  d = smooth_union(d, Capsule{{0.0, -84.0, 17.5}, 7.0, {0.0, -90.0, 15.5}, 7.0}.distance_mm(p),
                   10.0);                               // larynx
  return smooth_intersection(d, -105.0 - p.y(), 16.0);  // the base
}

void Bust::model_ear() {
  // Knots in ear coordinates. The helix rises from the floor of the concha and runs around to the lobe.
  helix_ = Sweep({{{1.5, -2.0, -5.6}, 1.2},
                  {{4.0, 0.6, -3.6}, 1.5},
                  {{6.2, 2.8, -1.0}, 1.8},
                  {{9.3, 7.8, 0.8}, 2.0},
                  {{9.4, 14.5, 1.7}, 2.2},
                  {{5.5, 20.2, 1.9}, 2.2},
                  {{-1.5, 22.5, 2.1}, 2.2},
                  {{-8.5, 19.9, 2.1}, 2.2},
                  {{-12.9, 13.5, 2.1}, 2.1},
                  {{-14.2, 5.5, 1.9}, 2.0},
                  {{-13.0, -3.0, 1.4}, 1.9},
                  {{-9.7, -10.0, 0.8}, 1.8},
                  {{-6.0, -16.0, 0.3}, 1.7},
                  {{-2.0, -21.0, 0.0}, 1.7},
                  {{3.0, -22.3, 0.0}, 1.7},
                  {{6.5, -18.0, 0.0}, 1.6},
                  {{8.5, -13.0, -1.0}, 1.8}});
  antihelix_ = Sweep({{{4.0, -12.0, 0.4}, 1.7},
                      {{-2.0, -11.7, 1.0}, 2.2},
                      {{-6.3, -6.5, 1.3}, 2.1},
                      {{-7.6, 2.0, 1.4}, 2.3},
                      {{-5.8, 9.5, 0.9}, 2.1},
                      {{-2.5, 16.0, -0.2}, 1.5}});
  antihelix_fork_ = Sweep({{{-7.0, 4.5, 1.0}, 1.9}, {{-1.0, 8.6, 0.5}, 1.8}, {{6.5, 10.0, -0.8}, 1.4}});
  scapha_ = Sweep({{{5.5, 15.5, 2.8}, 1.4},
                   {{3.0, 17.8, 2.8}, 1.8},
                   {{-2.0, 19.0, 2.8}, 1.9},
                   {{-7.0, 17.0, 2.8}, 1.9},
                   {{-10.2, 12.0, 2.8}, 1.8},
                   {{-11.2, 5.0, 2.7}, 1.7},
                   {{-10.2, -3.0, 2.2}, 1.3}});
}

double Bust::with_ear(double d, const Vec3d& p) const {
  if (is_out_of_reach(p, ear_.origin_mm, kEarReach_mm - 6.0, d, 6.0)) return d;
  const Vec3d e = ear_.to_local(p);
  // The pinna is a thin plate, dished towards the front, with the lobe below.
  const double upper = (e.head<2>() - Vec2d(-2.0, 5.5)).cwiseQuotient(Vec2d(12.8, 17.3)).norm();
  const double lower = (e.head<2>() - Vec2d(1.0, -13.0)).cwiseQuotient(Vec2d(7.7, 9.7)).norm();
  const double outline_mm = smooth_union((upper - 1.0) * 13.0, (lower - 1.0) * 8.0, 6.0);
  const double dish_mm = 2.0 * smooth_step(-9.0, 0.0, outline_mm) - 1.2;
  double ear = smooth_intersection(outline_mm, std::abs(e.z() - dish_mm) - 1.5, 2.0);
  ear = smooth_union(ear, Ellipsoid{{1.5, -17.5, 0.0}, {6.0, 5.5, 2.4}}.distance_mm(e), 3.0);
  // The bowl of the concha, and what joins it to the skull.
  const double bowl = Ellipsoid{{2.0, -3.8, 0.5}, {9.4, 10.4, 9.4}}.distance_mm(e);
  ear = smooth_union(ear, smooth_intersection(bowl, e.z() - 0.2, 2.0), 3.0);
  ear = smooth_union(ear, Ellipsoid{{4.5, -1.5, -7.0}, {9.5, 12.5, 7.0}}.distance_mm(e), 4.0);
  const double hollow = Ellipsoid{{2.0, -3.8, 1.2}, {6.8, 7.8, 6.8}}.distance_mm(e);
  ear = smooth_difference(ear, hollow, 2.5);
  // The rim curls over the groove behind it; the antihelix and its fork stand in front of that.
  ear = with_sweep(ear, helix_, e, 2.2);
  ear = smooth_difference(ear, scapha_.distance_mm(e), 1.8);
  ear = with_sweep(ear, antihelix_, e, 2.6);
  ear = with_sweep(ear, antihelix_fork_, e, 2.6);
  const double all = smooth_union(smooth_difference(d, hollow, 2.5), ear, 5.0);
  return smooth_union(all, Capsule{{11.0, -5.5, -0.5}, 3.0, {8.0, -4.0, 2.6}, 2.0}.distance_mm(e),
                      3.5);  // tragus
}

HeadPart Bust::part(const Vec3d& p) const {
  const Vec3d half = fold(p);
  const Vec3d e = ear_.to_local(half);
  if (e.norm() < kEarReach_mm && std::abs(earless_mm(half)) > 1.0)
    return e.z() > -0.5 ? HeadPart::ear_front : HeadPart::ear_back;
  if (p.y() < -102.5) return HeadPart::base;
  // The jaw line from chin to ear, and level behind it.
  const double jaw_y_mm = -72.0 + 38.0 * smooth_step(40.0, -8.0, p.z());
  // Across the temples and the top of the forehead, so that the face fills its chart.
  const bool is_front = p.z() > -8.0 + 0.45 * std::max(0.0, p.y() - 15.0);
  if (p.y() < jaw_y_mm) return is_front ? HeadPart::neck_front : HeadPart::neck_back;
  return is_front ? HeadPart::face : HeadPart::scalp;
}

const Bust& bust() {
  static const Bust instance;
  return instance;
}

}  // namespace

double head_distance_mm(const Vec3d& p_mm) { return bust().distance_mm(p_mm); }

ImplicitSample head_sample(const Vec3d& p_mm) {
  // The corners of a tetrahedron: four values give the value and the gradient, to second order.
  constexpr double h = 0.01;
  static const std::array<Vec3d, 4> corners = {Vec3d(1, 1, 1), Vec3d(1, -1, -1), Vec3d(-1, 1, -1),
                                               Vec3d(-1, -1, 1)};
  ImplicitSample sample{0.0, Vec3d::Zero()};
  for (const Vec3d& c : corners) {
    const double value = head_distance_mm(p_mm + h * c);
    sample.value_mm += 0.25 * value;
    sample.gradient += value / (4.0 * h) * c;
  }
  return sample;
}

double head_edge_mm(const Vec3d& p_mm, double edge_mm) {
  // Where detail sits: a ball, the edge length inside it, and how wide the passage outwards is.
  struct Detail {
    Vec3d center_mm;
    double radius_mm;
    double edge_factor;
    double longest_mm;
  };
  static const std::array<Detail, 5> details = {
      {{{57.0, 0.0, -13.0}, 27.0, 0.46, 1.2},   // ear
       {{7.0, -20.0, 69.0}, 11.0, 0.45, 1.1},   // nostrils
       {{5.0, -38.0, 69.0}, 9.0, 0.42, 1.05},   // lips
       {{15.0, -38.5, 62.0}, 7.0, 0.42, 1.05},  // corner of the mouth
       {{23.0, 9.0, 52.0}, 15.0, 0.4, 1.0}}};   // lids
  const Vec3d half(std::abs(p_mm.x()), p_mm.y(), p_mm.z());
  double result_mm = edge_mm;
  for (const Detail& detail : details) {
    const double fine_mm = std::min(edge_mm * detail.edge_factor, detail.longest_mm);
    const double outside_mm = std::max(0.0, (half - detail.center_mm).norm() - detail.radius_mm);
    result_mm = std::min(result_mm, fine_mm + 0.3 * outside_mm);
  }
  return result_mm;
}

HeadPart head_part(const Vec3d& p_mm) { return bust().part(p_mm); }

}  // namespace truescatter
