#include "truth/piece_nodes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace truescatter {
namespace {

constexpr Eigen::Index kBlock = 8;
// Nothing that counts lies this far out (exp(-60) = 9e-27), and denormal numbers are slow.
constexpr double kSmallestExponent = -60.0;
// Beyond that many radii from its source a cone is smooth to any rule.
constexpr double kNearSource = 3.0;
constexpr double kCurved = 1.2;

template <typename Scalar>
using Lane = Eigen::Array<Scalar, kBlock, 1>;

// The largest |f'| of the Gaussian f over an interval: |f'| = r/s^2 f grows up to r = s and falls from there.
double steepest(const TruthLayer& layer, double nearest_mm, double farthest_mm) {
  const double s = layer.std_dev_mm;
  const double r = std::clamp(s, std::max(nearest_mm, 0.0), std::max(farthest_mm, 0.0));
  return r / (s * s) * std::exp(-0.5 * (r / s) * (r / s)) / (2.0 * kPi * s * s);
}

}  // namespace

template <typename Scalar>
SplitNodes<Scalar>::SplitNodes(const Split& of) : split(of) {
  std::vector<Vec3d> places;
  std::vector<double> weights;
  const int n = split.parts;
  const auto corner = [&](int i, int j) { return Vec3d(Vec3d(n - i - j, i, j) / n); };
  const auto add_part = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    for (const TriangleNode& node : split.rule->nodes) {
      places.emplace_back(node.barycentric[0] * a + node.barycentric[1] * b + node.barycentric[2] * c);
      weights.push_back(node.weight / (n * n));
    }
    middles.emplace_back(((a + b + c) / 3.0).template head<2>());
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      add_part(corner(i, j), corner(i + 1, j), corner(i, j + 1));
      if (i + j + 1 < n) add_part(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
  }
  const auto count = static_cast<Eigen::Index>(places.size());
  const Eigen::Index padded = (count + kBlock - 1) / kBlock * kBlock;
  b0 = Array::Constant(padded, Scalar(1) / 3);
  b1 = Array::Constant(padded, Scalar(1) / 3);
  weight = Array::Zero(padded);
  for (Eigen::Index i = 0; i < count; ++i) {
    b0[i] = static_cast<Scalar>(places[static_cast<std::size_t>(i)][0]);
    b1[i] = static_cast<Scalar>(places[static_cast<std::size_t>(i)][1]);
    weight[i] = static_cast<Scalar>(weights[static_cast<std::size_t>(i)]);
  }
  weight_b0 = weight * b0;
  weight_b1 = weight * b1;
}

template <typename Scalar>
void PieceNodes<Scalar>::prepare(const FlatPiece& piece, const SplitNodes<Scalar>& nodes,
                                 std::span<const GeodesicWindow* const> windows, double slack_mm) {
  piece_ = &piece;
  nodes_ = &nodes;
  area_mm2_ = piece.area_mm2();
  part_radius_mm_ = piece.radius_mm() / nodes.split.parts;
  const Eigen::Index count = nodes.b0.size();
  squared_.resize(count);
  if (windows.size() > 1) squared_.setConstant(std::numeric_limits<Scalar>::max());
  for (const GeodesicWindow* window : windows) {
    const Vec2d origin = piece.corners_mm[2] - window->source;
    const Vec2d e0 = piece.corners_mm[0] - piece.corners_mm[2];
    const Vec2d e1 = piece.corners_mm[1] - piece.corners_mm[2];
    const auto scalar = [](double v) { return static_cast<Scalar>(v); };
    const bool alone = windows.size() == 1;
    for (Eigen::Index i = 0; i < count; i += kBlock) {
      const Lane<Scalar> b0 = nodes.b0.template segment<kBlock>(i);
      const Lane<Scalar> b1 = nodes.b1.template segment<kBlock>(i);
      const Lane<Scalar> x = scalar(origin.x()) + b0 * scalar(e0.x()) + b1 * scalar(e1.x());
      const Lane<Scalar> y = scalar(origin.y()) + b0 * scalar(e0.y()) + b1 * scalar(e1.y());
      Lane<Scalar> squared = x.square() + y.square();
      if (window->offset_mm > 0.0) squared = (squared.sqrt() + scalar(window->offset_mm)).square();
      if (alone) {
        squared_.template segment<kBlock>(i) = squared;
        continue;
      }
      if (!window->all_round) {
        const Lane<Scalar> over_left = scalar(window->left.x()) * y - scalar(window->left.y()) * x;
        const Lane<Scalar> over_right = x * scalar(window->right.y()) - y * scalar(window->right.x());
        squared = (over_left.max(over_right) <= scalar(slack_mm))
                      .select(squared, Lane<Scalar>::Constant(std::numeric_limits<Scalar>::max()));
      }
      squared_.template segment<kBlock>(i) = squared_.template segment<kBlock>(i).min(squared);
    }
  }
  find_kinks(windows);
}

template <typename Scalar>
Vec4d PieceNodes<Scalar>::sum(const TruthLayer& layer) const {
  const double s2 = layer.std_dev_mm * layer.std_dev_mm;
  const auto factor = static_cast<Scalar>(-0.5 / s2);
  Lane<Scalar> all = Lane<Scalar>::Zero();
  Lane<Scalar> first = Lane<Scalar>::Zero();
  Lane<Scalar> second = Lane<Scalar>::Zero();
  for (Eigen::Index i = 0; i < squared_.size(); i += kBlock) {
    const Lane<Scalar> kernel =
        (squared_.template segment<kBlock>(i) * factor).max(static_cast<Scalar>(kSmallestExponent)).exp();
    all += kernel * nodes_->weight.template segment<kBlock>(i);
    first += kernel * nodes_->weight_b0.template segment<kBlock>(i);
    second += kernel * nodes_->weight_b1.template segment<kBlock>(i);
  }
  const double scale = area_mm2_ / (2.0 * kPi * s2);
  const auto total = static_cast<double>(all.sum()) * scale;
  const auto at0 = static_cast<double>(first.sum()) * scale;
  const auto at1 = static_cast<double>(second.sum()) * scale;
  Vec4d result;
  result.head<3>() =
      at0 * piece_->irradiance[0] + at1 * piece_->irradiance[1] + (total - at0 - at1) * piece_->irradiance[2];
  result[3] = total;
  return result;
}

template <typename Scalar>
double PieceNodes<Scalar>::kink_variance(const TruthLayer& layer) const {
  const auto parts = static_cast<double>(nodes_->middles.size());
  const double scale = 0.5 * area_mm2_ / parts * part_radius_mm_ * nodes_->split.rule->kink_rms;
  double sum = 0.0;
  for (const Kink& kink : kinks_) {
    const double rms = scale * kink.jump * steepest(layer, kink.nearest_mm, kink.farthest_mm);
    sum += rms * rms;
  }
  return sum;
}

template <typename Scalar>
void PieceNodes<Scalar>::find_kinks(std::span<const GeodesicWindow* const> windows) {
  kinks_.clear();
  if (windows.size() == 1 && windows.front()->offset_mm == 0.0) return;
  const double radius_mm = part_radius_mm_;
  const auto& c = piece_->corners_mm;
  for (const Vec2d& middle : nodes_->middles) {
    const Vec2d x = middle[0] * c[0] + middle[1] * c[1] + (1.0 - middle[0] - middle[1]) * c[2];
    arrivals_.clear();
    double jump = 0.0;
    std::size_t shortest = 0;
    for (const GeodesicWindow* window : windows) {
      if (window->beyond_rays(x) > radius_mm) continue;
      const Vec2d along = x - window->source;
      const double rho = along.norm();
      if (window->offset_mm > 0.0 && rho < kNearSource * radius_mm)
        jump = std::max(jump, std::min((window->left - window->right).norm(), 2.0));
      arrivals_.push_back({window->offset_mm + rho, rho > 0.0 ? Vec2d(along / rho) : along});
      if (arrivals_.back().length_mm < arrivals_[shortest].length_mm) shortest = arrivals_.size() - 1;
    }
    if (arrivals_.empty()) continue;
    const Arrival* owner = &arrivals_[shortest];
    for (const Arrival& other : arrivals_) {
      const double between = (other.direction - owner->direction).norm();
      // The two lengths' difference changes by no more than that over the part, but for its curvature.
      if (other.length_mm - owner->length_mm < kCurved * between * radius_mm) jump = std::max(jump, between);
    }
    if (jump > 1e-9) kinks_.push_back({jump, owner->length_mm - radius_mm, owner->length_mm + radius_mm});
  }
}

template struct SplitNodes<float>;
template struct SplitNodes<double>;
template class PieceNodes<float>;
template class PieceNodes<double>;

}  // namespace truescatter
