#pragma once

#include <algorithm>
#include <cmath>

#include "core/image.h"

namespace truescatter::test {

// The largest |a - b| over all values of two images of one size.
inline double largest_difference(const Image& a, const Image& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.data().size(); ++i)
    largest =
        std::max(largest, std::abs(static_cast<double>(a.data()[i]) - static_cast<double>(b.data()[i])));
  return largest;
}

}  // namespace truescatter::test
