#pragma once

#include <array>
#include <cassert>
#include <span>
#include <vector>

#include "truth/edge_formula.h"
#include "truth/geodesic_surface.h"

namespace truescatter {

// A convex polygon of few corners, counter-clockwise. A triangle cut by the rays of two windows has at most
// 7; the rest is for corners that no computed side tells apart.
struct FlatPolygon {
  static constexpr std::size_t kCapacity = 12;
  std::array<Vec2d, kCapacity> corners;
  std::size_t size = 0;

  void push_back(const Vec2d& corner) {
    assert(size < kCapacity);
    corners[size++] = corner;
  }
  const Vec2d& operator[](std::size_t i) const { return corners[i]; }
  const Vec2d& after(std::size_t i) const { return corners[i + 1 == size ? 0 : i + 1]; }
};

// The part of a polygon that a window covers; empty where less than a triangle is left.
FlatPolygon covered(const GeodesicWindow& window, const FlatPolygon& polygon);

// The integral of f(d) I over a piece of surface, d being the least length over the windows that cover it.
//
// What a window owns of a (convex) piece is seen from its (pseudo-)source as an interval on every ray: it
// begins where the ray enters the piece and ends where the ray leaves it or where another window's paths
// become the shorter ones; once lost, a ray stays lost, for a path that is not the shortest at one of its
// points is not the shortest beyond. So the piece is taken sector by sector, a sector being bounded by two
// rays, a near edge of the piece (none, if the source lies inside) and a far edge or the curve on which two
// lengths agree.
//
// - A sector of a source of offset 0 between straight lines (the curve is straight for equal offsets) is
//   closed: the boundary integrals of README, Definitions, with h = 0.
// - Any other is one integral over the angle,
//     int [i0 (A(far) - A(near)) + (g.u) (B(far) - B(near))] dtheta,
//     A = int_0^rho t f(offset + t) dt,  B = int_0^rho t^2 f(offset + t) dt,
//   closed by erf for a Gaussian, i0 + g.x being the irradiance about the source; by adaptive Gauss-Kronrod
//   quadrature over stretches on which the integrand is smooth.
// - Over a needle irradiance changes so fast that both lose digits, some 1e-16 s / height. What one source of
//   offset 0 owns of a piece thinner than s/100 is taken by convolve_needle. A piece thinner than 1e-6 s is
//   taken whole by quadrature along it, of the least length at each node: a kink of the distance costs at
//   most some 1e-4 height / s there, and so 1e-10.
class PieceIntegral {
 public:
  struct Accuracy {
    bool to_rounding = true;          // of the closed forms; otherwise to 1e-7 of a plane's mass
    double quadrature_error = 1e-12;  // of a plane's mass, over one sector
    double reach_std_devs = 8.6;      // what lies farther than that may be left out
    double largest_irradiance = 1.0;  // the unit of errors in light
  };
  explicit PieceIntegral(const Accuracy& accuracy) : accuracy_(accuracy) {}

  // Adds each layer's integral over the piece to `sums`. `windows`: all that may hold a shortest path to a
  // point of it.
  void add(const FlatPiece& piece, std::span<const GeodesicWindow* const> windows,
           std::span<const TruthLayer> layers, std::span<Vec4d> sums);

 private:
  // The line that bounds a sector, seen from the source: at signed distance p along its normal.
  struct Line {
    Vec2d normal;  // pointing away from the source if p > 0
    Vec2d along;   // counter-clockwise about the source if p > 0
    double p;

    double place_on(const Vec2d& direction) const { return p * direction.dot(along) / direction.dot(normal); }
    double distance_on(const Vec2d& direction) const { return p / direction.dot(normal); }
  };
  // An edge of the current polygon; places along its line.
  struct Edge {
    Line line;
    double first;
    double last;
  };
  // What ends a ray.
  struct End {
    static constexpr int kEdge = -1;   // the far edge
    static constexpr int kEntry = -2;  // it is lost where it enters
    static constexpr int kOther = -3;  // a rival's first ray
    double distance_mm;
    int what;  // one of these, or the rival with which it is shared from here on

    bool operator==(const End& other) const { return what == other.what; }
  };
  struct Sector {
    const Edge* far;
    Line near;    // at distance 0: none
    double from;  // places on the far edge's line
    double to;
    int end;
  };

  void take_window(const FlatPiece& piece);
  bool choose_layers(double nearest_mm, std::span<const TruthLayer> layers);
  void find_rivals(std::span<const GeodesicWindow* const> windows);
  bool may_take(const GeodesicWindow& rival, const FlatPolygon& shared) const;
  std::array<double, 2> equal_lengths(const GeodesicWindow& rival, const Vec2d& a, const Vec2d& b) const;
  void add_polygon(const FlatPiece& piece, std::span<const TruthLayer> layers, std::span<Vec4d> sums) const;
  bool is_thin(const TruthLayer& layer) const;
  void add_thin(const FlatPiece& piece, std::span<const GeodesicWindow* const> windows,
                const TruthLayer& layer, Vec4d& sum) const;
  Vec4d needle(const FlatPiece& piece, const TruthLayer& layer) const;
  void add_far_edge(const Edge& far, std::span<const TruthLayer> layers, std::span<Vec4d> sums);
  void add_stretch(const Edge& far, double from, double to, std::span<const TruthLayer> layers,
                   std::span<Vec4d> sums);
  void add_sector(const Sector& sector, std::span<const TruthLayer> layers, std::span<Vec4d> sums);
  Vec4d closed_sector(const Sector& sector, const Line& bound, const TruthLayer& layer) const;
  void integrate_sector(const Sector& sector, std::span<const TruthLayer> layers, std::span<Vec4d> sums);
  Line near_line(const Vec2d& direction) const;
  End end_of_ray(const Vec2d& direction, const Edge& far) const;
  EdgeIntegrals edge(double p, double t0, double t1, const TruthLayer& layer) const;
  Vec4d combine(double radial, const Vec2d& line) const;
  Line bisector(const GeodesicWindow& rival) const;
  template <typename Integrand>
  void adaptive(const Integrand& integrand, double from, double to, int depth, std::span<Vec4d> sums) const;

  Accuracy accuracy_;
  const GeodesicWindow* window_ = nullptr;          // the current one
  FlatPolygon seen_;                                // of the piece
  std::array<Edge, FlatPolygon::kCapacity> edges_;  // of what is seen
  double size_mm_ = 0.0;                            // of the piece
  double height_mm_ = 0.0;                          // its smallest
  Vec3d i0_;                                        // irradiance about the source
  Vec3d gradient_x_;
  Vec3d gradient_y_;
  bool exact_edges_ = true;
  std::vector<std::size_t> layers_;  // that reach the piece
  std::vector<const GeodesicWindow*> rivals_;
  std::vector<Vec2d> turning_points_;  // seen from the source, directions in which the owner may change
  std::vector<double> breaks_;
};

}  // namespace truescatter
