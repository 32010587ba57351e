#pragma once

#include <algorithm>
#include <vector>

#ifndef __SANITIZE_THREAD__
#include <tbb/parallel_sort.h>
#endif

namespace truescatter {

// Sorts by T's <, on the threads of the enclosing JobLimit; what is equal may end up in any order. On the
// caller's thread alone under the thread sanitizer (see parallel.cpp).
template <typename T>
void parallel_sort(std::vector<T>& values) {
#ifdef __SANITIZE_THREAD__
  std::sort(values.begin(), values.end());
#else
  tbb::parallel_sort(values.begin(), values.end());
#endif
}

}  // namespace truescatter
