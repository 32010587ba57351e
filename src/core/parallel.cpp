#include "core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#endif

namespace truescatter {

#ifdef __SANITIZE_THREAD__
// The thread sanitizer does not see how oneTBB's library, which is not compiled for it, hands work from
// thread to thread, and would take every result for a race: under it, plain threads run the same bodies.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::thread> others;
  for (std::size_t j = 1; j < std::min(static_cast<std::size_t>(job_count()), count); ++j)
    others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
  if (failure) std::rethrow_exception(failure);
}
#else
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
                    });
}
#endif

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

int jobs_within(double bytes_each, int jobs) {
  constexpr double kMostBytes = 4.0 * 1024.0 * 1024.0 * 1024.0;
  return static_cast<int>(std::clamp(kMostBytes / std::max(bytes_each, 1.0), 1.0, std::max(1.0, jobs + 0.0)));
}

}  // namespace truescatter
