#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "truth/geodesic_surface.h"
#include "truth/quadrature.h"

namespace truescatter {

// The nodes of a split in the piece's barycentric coordinates, which are the same for every piece; padded to
// a multiple of 8 with nodes of no weight.
template <typename Scalar>
struct SplitNodes {
  using Array = Eigen::Array<Scalar, Eigen::Dynamic, 1>;
  explicit SplitNodes(const Split& split);

  Split split;
  Array b0;
  Array b1;
  Array weight;                // sums to 1
  Array weight_b0;             // weight * b0
  Array weight_b1;             // weight * b1
  std::vector<Vec2d> middles;  // of the parts: b0 and b1
};

// Integrates f(d) I over a piece by quadrature, d being the least length over the windows that cover a node.
template <typename Scalar>
class PieceNodes {
 public:
  // Finds the distances at the nodes. `windows`: all that may hold a shortest path to a point of the piece;
  // `slack_mm`: how far beyond its rays a window is still taken to reach, for rounding's sake.
  void prepare(const FlatPiece& piece, const SplitNodes<Scalar>& nodes,
               std::span<const GeodesicWindow* const> windows, double slack_mm);

  // A layer's integral over the piece, which r_max does not cut.
  Vec4d sum(const TruthLayer& layer) const;

  // What kinks of the distance may add to the rule's error, for light of at most 1: where two windows cover a
  // part and their lengths agree somewhere near it, the distance's gradient jumps by J, which is J/2 times
  // the distance from the kink on top of something smooth (TriangleRule::kink_error). About a pseudo-source
  // in or near a part lengths form a cone, whose gradients differ by the width of the window. Where a kink
  // lies among a part's nodes is as good as random, so the parts' mean squares add.
  double kink_variance(const TruthLayer& layer) const;

 private:
  struct Kink {
    double jump;
    double nearest_mm;
    double farthest_mm;
  };
  // A window's path at a place.
  struct Arrival {
    double length_mm;
    Vec2d direction;
  };
  void find_kinks(std::span<const GeodesicWindow* const> windows);

  const FlatPiece* piece_ = nullptr;
  const SplitNodes<Scalar>* nodes_ = nullptr;
  double area_mm2_ = 0.0;
  double part_radius_mm_ = 0.0;
  typename SplitNodes<Scalar>::Array squared_;  // distances
  std::vector<Kink> kinks_;                     // one for each part that has one
  std::vector<Arrival> arrivals_;
};

}  // namespace truescatter
