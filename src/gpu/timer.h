#pragma once

#include <functional>

#include "gpu/context.h"

namespace truescatter::gpu {

// Times of one repeated piece of GPU work, in milliseconds.
struct FrameTimes {
  double median_ms = 0.0;
  double min_ms = 0.0;
  double max_ms = 0.0;
  int repeats = 0;
};

// Runs `work` `warm_up` times, then `repeats` (>= 1) times, each between two glFinish.
FrameTimes time_frames(const Context& context, const std::function<void()>& work, int warm_up, int repeats);

}  // namespace truescatter::gpu
