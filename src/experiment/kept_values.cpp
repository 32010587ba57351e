#include "experiment/kept_values.h"

#include <cassert>
#include <optional>

#include "core/content_hash.h"
#include "core/stopwatch.h"

namespace truescatter {
namespace {

CachedLayer timed(const std::function<std::vector<Vec4d>()>& compute) {
  const Stopwatch watch;
  CachedLayer computed{compute(), 0.0};
  computed.seconds = watch.seconds();
  return computed;
}

}  // namespace

CachedLayer KeptValues::values(const std::string& content, std::optional<std::size_t> count,
                               const std::function<std::vector<Vec4d>()>& compute) const {
  if (!are_kept()) return timed(compute);
  ContentHash hash;
  hash.append(program_);
  hash.append(content);
  const std::string key = hash.hex();
  if (std::optional<CachedLayer> found = cache_->find(key, count)) return *std::move(found);
  // Who holds this claim waits for nothing else, so it may be asked for while a view's truths are claimed.
  const CacheClaim claim = cache_->claim(key, 1, count.value_or(0));
  if (std::optional<CachedLayer> found = cache_->find(key, count)) return *std::move(found);
  CachedLayer computed = timed(compute);
  assert(!count || computed.values.size() == *count);
  cache_->store(key, computed);
  return computed;
}

TruthValues KeptValues::truth_values(const std::string& content, std::size_t layers, std::size_t points,
                                     const std::function<TruthValues()>& compute) const {
  if (!are_kept()) return compute();
  const std::vector<Vec4d> flat = values(content, layers * points, [&] {
                                    std::vector<Vec4d> all;
                                    for (const std::vector<Vec4d>& layer : compute())
                                      all.insert(all.end(), layer.begin(), layer.end());
                                    return all;
                                  }).values;
  TruthValues layered;
  for (auto at = flat.begin(); at != flat.end(); at += static_cast<std::ptrdiff_t>(points))
    layered.emplace_back(at, at + static_cast<std::ptrdiff_t>(points));
  return layered;
}

}  // namespace truescatter
