#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/vec.h"
#include "truth/cache.h"
#include "truth/surface.h"

namespace truescatter {

// What a part of an experiment may leave to another one that comes to it first, beside truths: the exact
// values that audits compare with, and light by its ways. They are as good as computed here, for the same
// program computed them from the same content; what is compared with them is compared by every part. A whole
// run leaves nothing to others, and computes them each time.
class SharedValues {
 public:
  // Shares nothing: all is computed.
  SharedValues() = default;
  // Through the cache, which outlives it; null shares nothing. `program`: a hash of the program's content.
  SharedValues(TruthCache* cache, std::string program) : cache_(cache), program_(std::move(program)) {}

  bool are_shared() const { return cache_ != nullptr; }

  // `count` values that depend on the program and on `content` (a text or a hash) alone: another part's, or
  // `compute`'s, which others wait for meanwhile. `seconds`: what computing them took, whenever that was.
  // What `compute` throws is passed on.
  CachedLayer values(const std::string& content, std::size_t count,
                     const std::function<std::vector<Vec4d>()>& compute) const;
  // The same of `layers` values at each of `points` points.
  TruthValues truth_values(const std::string& content, std::size_t layers, std::size_t points,
                           const std::function<TruthValues()>& compute) const;

 private:
  TruthCache* cache_ = nullptr;
  std::string program_;
};

}  // namespace truescatter
