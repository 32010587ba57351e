#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/vec.h"
#include "truth/cache.h"
#include "truth/surface.h"

namespace truescatter {

// Values beside truths that the cache keeps for later runs of the same program, and for other parts of an
// experiment: generated meshes; for parts also the exact values that audits compare with, and light by its
// ways. They are as good as computed here, for the same program computed them from the same content.
class KeptValues {
 public:
  // Keeps nothing: all is computed.
  KeptValues() = default;
  // In the cache, which outlives it; null keeps nothing. `program`: a hash of the program's content.
  KeptValues(TruthCache* cache, std::string program) : cache_(cache), program_(std::move(program)) {}

  bool are_kept() const { return cache_ != nullptr; }

  // Values that depend on the program and on `content` (a text or a hash) alone: kept ones, or `compute`'s,
  // which other processes wait for meanwhile. `count`: how many there are, where that is known. `seconds`:
  // what computing them took, whenever that was. What `compute` throws is passed on.
  CachedLayer values(const std::string& content, std::optional<std::size_t> count,
                     const std::function<std::vector<Vec4d>()>& compute) const;
  // The same of `layers` values at each of `points` points.
  TruthValues truth_values(const std::string& content, std::size_t layers, std::size_t points,
                           const std::function<TruthValues()>& compute) const;

 private:
  TruthCache* cache_ = nullptr;
  std::string program_;
};

}  // namespace truescatter
