#include "truth/needle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace truescatter {
namespace {

// Beyond lies less than rounding (ExactEngine).
constexpr double kReachStdDevs = 8.6;

// Calls visit(x, weight) for the nodes of a rule with 2 N nodes, or 2 N - 1 where the first is 0, on [a, b].
template <std::size_t N, typename Visit>
void for_each_line_node(const std::array<double, N>& nodes, const std::array<double, N>& weights, double a,
                        double b, const Visit& visit) {
  const double middle = 0.5 * (a + b);
  const double half = 0.5 * (b - a);
  for (std::size_t i = 0; i < N; ++i) {
    visit(middle + half * nodes[i], half * weights[i]);
    if (nodes[i] > 0.0) visit(middle - half * nodes[i], half * weights[i]);
  }
}

template <typename Visit>
void along_nodes(double a, double b, const Visit& visit) {
  static constexpr std::array<double, 4> kNodes = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                                   0.9602898564975363};
  static constexpr std::array<double, 4> kWeights = {0.3626837833783620, 0.3137066458778873,
                                                     0.2223810344533745, 0.1012285362903763};
  for_each_line_node(kNodes, kWeights, a, b, visit);
}

template <typename Visit>
void across_nodes(double a, double b, const Visit& visit) {
  static constexpr std::array<double, 2> kNodes = {0.0, 0.7745966692414834};
  static constexpr std::array<double, 2> kWeights = {8.0 / 9.0, 5.0 / 9.0};
  for_each_line_node(kNodes, kWeights, a, b, visit);
}

// A corner with its irradiance.
struct Corner {
  Vec3d position_mm;
  Vec3d irradiance;
};

// The right triangle from `tip` to `foot` and up to `top`: 0 <= t <= length, 0 <= y <= slope t.
class RightTriangle {
 public:
  RightTriangle(const Corner& tip, const Corner& foot, const Corner& top, const Vec3d& point_mm,
                const TruthLayer& layer)
      : std_dev_mm_(layer.std_dev_mm), at_tip_(tip.irradiance) {
    Vec3d along = foot.position_mm - tip.position_mm;
    Vec3d across = top.position_mm - foot.position_mm;
    length_ = along.norm();
    const double height = across.norm();
    if (!(length_ > 0.0) || !(height > 0.0)) {
      length_ = 0.0;
      return;
    }
    along /= length_;
    across /= height;
    slope_ = height / length_;
    per_t_ = (foot.irradiance - tip.irradiance) / length_;
    per_y_ = (top.irradiance - foot.irradiance) / height;
    const Vec3d offset = point_mm - tip.position_mm;
    point_t_ = offset.dot(along);
    point_y_ = offset.dot(across);
    above2_ = (offset - point_t_ * along - point_y_ * across).squaredNorm();
    cut2_ = layer.r_max_mm * layer.r_max_mm - above2_;
  }

  Vec4d value() const {
    if (length_ == 0.0 || cut2_ <= 0.0) return Vec4d::Zero();
    const double reach = std::min(kReachStdDevs * std_dev_mm_, std::sqrt(cut2_));
    const double first = std::max(0.0, point_t_ - reach);
    const double last = std::min(length_, point_t_ + reach);
    if (!(last > first)) return Vec4d::Zero();
    std::array<double, 6> ends = crossings(first);
    ends[4] = first;
    ends[5] = last;
    for (double& t : ends) t = std::clamp(t, first, last);
    std::sort(ends.begin(), ends.end());
    Vec4d sum = Vec4d::Zero();
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
      if (ends[i + 1] > ends[i]) sum += between(ends[i], ends[i + 1]);
    }
    return sum;
  }

 private:
  // Where the cut circle crosses the lines of the two long edges; `none` where it does not.
  std::array<double, 6> crossings(double none) const {
    std::array<double, 6> found{};
    found.fill(none);
    if (!std::isfinite(cut2_)) return found;
    std::size_t next = 0;
    for (const double k : {0.0, slope_}) {
      // (t - point_t)^2 + (k t - point_y)^2 = cut^2
      const double square = 1.0 + k * k;
      const double middle = (point_t_ + k * point_y_) / square;
      const double half2 = middle * middle - (point_t_ * point_t_ + point_y_ * point_y_ - cut2_) / square;
      if (half2 > 0.0) {
        found[next] = middle - std::sqrt(half2);
        found[next + 1] = middle + std::sqrt(half2);
      }
      next += 2;
    }
    return found;
  }

  Vec4d between(double begin, double end) const {
    const double scale = -0.5 / (std_dev_mm_ * std_dev_mm_);
    const int panels = std::max(1, static_cast<int>(std::ceil((end - begin) / std_dev_mm_)));
    Vec4d sum = Vec4d::Zero();
    for (int panel = 0; panel < panels; ++panel) {
      const double a = begin + (end - begin) * panel / panels;
      const double b = begin + (end - begin) * (panel + 1) / panels;
      along_nodes(a, b, [&](double t, double weight_t) {
        double low = 0.0;
        double high = slope_ * t;
        const double t2 = (t - point_t_) * (t - point_t_);
        if (std::isfinite(cut2_)) {
          const double half = std::sqrt(std::max(0.0, cut2_ - t2));
          low = std::max(low, point_y_ - half);
          high = std::min(high, point_y_ + half);
          if (high <= low) return;
        }
        across_nodes(low, high, [&](double y, double weight_y) {
          const double r2 = t2 + (y - point_y_) * (y - point_y_) + above2_;
          const double weight = weight_t * weight_y * std::exp(scale * r2);
          sum.head<3>() += weight * (at_tip_ + t * per_t_ + y * per_y_);
          sum[3] += weight;
        });
      });
    }
    return sum * (-scale / kPi);
  }

  double std_dev_mm_;
  Vec3d at_tip_;  // irradiance
  Vec3d per_t_ = Vec3d::Zero();
  Vec3d per_y_ = Vec3d::Zero();
  double length_ = 0.0;  // 0: no area
  double slope_ = 0.0;
  double point_t_ = 0.0;
  double point_y_ = 0.0;
  double above2_ = 0.0;  // squared height of the point over the plane
  double cut2_ = 0.0;    // squared radius of the cut circle in the plane
};

}  // namespace

Vec4d convolve_needle(const SurfaceTriangle& triangle, const Vec3d& point_mm, const TruthLayer& layer) {
  std::size_t longest = 0;
  double length2 = 0.0;
  const auto& x = triangle.corners_mm;
  for (std::size_t e = 0; e < 3; ++e) {
    const double edge2 = (x[(e + 1) % 3] - x[e]).squaredNorm();
    if (edge2 > length2) {
      length2 = edge2;
      longest = e;
    }
  }
  if (!(length2 > 0.0)) return Vec4d::Zero();
  const auto corner = [&](std::size_t c) { return Corner{x[c % 3], triangle.irradiance[c % 3]}; };
  const Corner a = corner(longest);
  const Corner b = corner(longest + 1);
  const Corner top = corner(longest + 2);
  const Vec3d edge = b.position_mm - a.position_mm;
  const double share = std::clamp((top.position_mm - a.position_mm).dot(edge) / length2, 0.0, 1.0);
  const Corner foot{a.position_mm + share * edge, a.irradiance + share * (b.irradiance - a.irradiance)};
  return RightTriangle(a, foot, top, point_mm, layer).value() +
         RightTriangle(b, foot, top, point_mm, layer).value();
}

}  // namespace truescatter
