#include "core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace truescatter {

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
                    });
}

JobLimit::JobLimit(int jobs)
    : control_(new tbb::global_control(tbb::global_control::max_allowed_parallelism,
                                       jobs > 0
                                           ? static_cast<std::size_t>(jobs)
                                           : static_cast<std::size_t>(tbb::info::default_concurrency()))) {}

JobLimit::~JobLimit() { delete static_cast<tbb::global_control*>(control_); }

int job_count() {
  return static_cast<int>(
      std::min(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism),
               static_cast<std::size_t>(tbb::info::default_concurrency())));
}

}  // namespace truescatter
