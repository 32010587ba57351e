#pragma once

#include <cstddef>
#include <functional>

namespace truescatter {

// Calls body(i) for every i in [0, count) on the threads of the enclosing JobLimit. The order is not
// defined: each body writes only what belongs to its i, so results do not depend on the number of jobs.
// An exception from a body is passed on to the caller.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

// While it lives, parallel_for uses at most `jobs` threads; 0 means all that the machine has.
class JobLimit {
 public:
  explicit JobLimit(int jobs);
  ~JobLimit();
  JobLimit(const JobLimit&) = delete;
  JobLimit& operator=(const JobLimit&) = delete;

 private:
  void* control_;
};

// The number of threads that parallel_for uses now.
int job_count();

// How many of `jobs` that each hold so many bytes may run at once, so that together they hold 4 GiB at most;
// one runs in any case.
int jobs_within(double bytes_each, int jobs);

}  // namespace truescatter
