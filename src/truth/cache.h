#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// A layer as a cache keeps it: the values at every point, and what computing them took.
struct CachedLayer {
  std::vector<Vec4d> values;
  double seconds = 0.0;
};

// Layers of truths on disk, one file for each, named by a hash of all that the values depend on. Several
// processes may use one folder: a file appears by a rename, whole, and processes that write one key write the
// same. Each file carries its length and a checksum: a damaged one is as good as none, is removed, and that
// is said on standard error. No failure of the cache is a failure of a run: it is said once, and computing
// goes on.
//
// The folder holds at most `limit_bytes`: what was used least recently goes first. Temporaries of processes
// that died, an hour old or older, are removed as others write.
class TruthCache {
 public:
  TruthCache(std::filesystem::path folder, std::uintmax_t limit_bytes);

  // The layer of this key (hexadecimal digits), which must have this many points; nothing if it is not there.
  std::optional<CachedLayer> find(const std::string& key, std::size_t points);
  void store(const std::string& key, const CachedLayer& layer);
  void forget(const std::string& key);

  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path file_of(const std::string& key) const;
  bool write(const std::filesystem::path& file, const std::string& bytes);
  void give_up(const std::string& reason);
  void remove_stale_temporaries() const;
  void keep_to_limit() const;

  std::filesystem::path folder_;
  std::uintmax_t limit_bytes_;
  bool writes_ = true;  // until a write fails
};

// The user's cache: in $TRUESCATTER_CACHE, else $XDG_CACHE_HOME/truescatter, else ~/.cache/truescatter, of
// $TRUESCATTER_CACHE_LIMIT_MIB (default 4096) MiB. Null, with a note on standard error, where none of these
// is set. Throws Error (input) if the limit is no whole number of 0 or more.
std::unique_ptr<TruthCache> open_user_cache();

}  // namespace truescatter
