#pragma once

#include <cstddef>
#include <vector>

namespace truescatter {

// Of the standard deviations of single points: over points that at least two views see.
struct SpreadStats {
  std::size_t points = 0;
  double rms = 0.0;
  double p95 = 0.0;  // nearest rank, as in ErrorStats
  double max = 0.0;
};

// How far apart the errors of a surface point lie over the views that see it. For point i with errors e_iv,
// v = 1..n_i: sigma_i = sqrt((1/n_i) sum_v (e_iv - mean_i)^2). Errors that are all the same have a spread of
// exactly 0, whatever they are.
class ErrorSpread {
 public:
  explicit ErrorSpread(std::size_t points) : of_point_(points) {}

  // The error of a point in one more view.
  void add(std::size_t point, double error);
  // Every value is NaN where no point was seen twice.
  SpreadStats stats() const;

 private:
  struct Moments {
    std::size_t views = 0;
    double mean = 0.0;
    double squares = 0.0;  // sum of squared differences from the mean
  };
  std::vector<Moments> of_point_;
};

}  // namespace truescatter
