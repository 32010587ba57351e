#include "truth/edge_fast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/sampling.h"
#include "truth/exact.h"

namespace truescatter {
namespace {

// The table's promise: 1e-8 by interpolation, and where the tables end, at 6 s, exp(-18) = 1.5e-8 times at
// most 1/2 for Owen's T, and for the line integral times sqrt(pi/2)/pi s. So 2e-8 of at_foot, and of s
// at_foot.
constexpr double kAllowedOfEdge = 2e-8;

// Everywhere that matters: near the foot, at and beyond the tables' end, edges on either side of the foot or
// across it, the point on the edge's line.
TEST(EdgeFast, IsTheExactEdgeWithinTheTablesPromise) {
  std::mt19937_64 generator(31);
  for (int i = 0; i < 200000; ++i) {
    const double s = std::exp(test::uniform(generator, -3.0, 3.0));
    const double span = i % 3 == 0 ? 0.5 : i % 3 == 1 ? 7.0 : 60.0;
    const double p = i % 11 == 0 ? 0.0 : s * test::uniform(generator, -span, span);
    double t0 = s * test::uniform(generator, -span, span);
    double t1 = s * test::uniform(generator, -span, span);
    if (t0 > t1) std::swap(t0, t1);
    const double at_foot = test::uniform(generator);
    const EdgeIntegrals fast = edge_inside_fast(p, t0, t1, s, at_foot);
    const EdgeIntegrals exact = edge_inside_exact(p, t0, t1, s, at_foot);
    ASSERT_NEAR(fast.radial, exact.radial, kAllowedOfEdge * at_foot)
        << "p " << p << " t " << t0 << " " << t1 << " s " << s;
    ASSERT_NEAR(fast.line, exact.line, kAllowedOfEdge * s * at_foot)
        << "p " << p << " t " << t0 << " " << t1 << " s " << s;
  }
}

}  // namespace
}  // namespace truescatter
