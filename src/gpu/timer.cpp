#include "gpu/timer.h"

#include <algorithm>
#include <cassert>
#include <vector>

#include "core/stopwatch.h"

namespace truescatter::gpu {

FrameTimes time_frames(const Context& context, const std::function<void()>& work, int warm_up, int repeats) {
  assert(repeats >= 1);
  for (int i = 0; i < warm_up; ++i) work();
  std::vector<double> times_ms;
  for (int i = 0; i < repeats; ++i) {
    context.finish();
    const Stopwatch watch;
    work();
    context.finish();
    times_ms.push_back(watch.milliseconds());
  }
  std::sort(times_ms.begin(), times_ms.end());
  const std::size_t n = times_ms.size();
  FrameTimes times;
  times.median_ms = n % 2 == 1 ? times_ms[n / 2] : 0.5 * (times_ms[n / 2 - 1] + times_ms[n / 2]);
  times.min_ms = times_ms.front();
  times.max_ms = times_ms.back();
  times.repeats = repeats;
  return times;
}

}  // namespace truescatter::gpu
