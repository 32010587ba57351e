#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/vec.h"

namespace truescatter {

// A layer as a cache keeps it: the values at every point, and what computing them took.
struct CachedLayer {
  std::vector<Vec4d> values;
  double seconds = 0.0;
};

// The right to compute what a cache lacks: while it lives, others who claim the same wait. The system takes
// it back from a process that dies; one that is stopped shows no sign of life, and is not waited for.
class CacheClaim {
 public:
  CacheClaim() noexcept;  // to nothing
  CacheClaim(CacheClaim&& other) noexcept;
  CacheClaim& operator=(CacheClaim&& other) noexcept;
  ~CacheClaim();

 private:
  friend class TruthCache;
  class Sign;  // of life
  CacheClaim(int descriptor, std::filesystem::path file);

  int descriptor_ = -1;
  std::filesystem::path file_;
  std::unique_ptr<Sign> sign_;
};

// Layers of truths on disk, one file for each, named by a hash of all that the values depend on. Several
// processes may use one folder: a file appears by a rename, whole, and processes that write one key write the
// same. Each file carries its length and a checksum: a damaged one is as good as none, is removed, and that
// is said on standard error. No failure of the cache is a failure of a run: it is said once, and computing
// goes on.
//
// The folder holds at most `limit_bytes`: what was used least recently goes first. Temporaries and claims of
// processes that died, an hour old or older, are removed as others write.
class TruthCache {
 public:
  // How long a process that has claimed something may show no sign of life: it shows one every five seconds.
  static constexpr std::chrono::milliseconds kPatience = std::chrono::minutes(1);

  TruthCache(std::filesystem::path folder, std::uintmax_t limit_bytes,
             std::chrono::milliseconds patience = kPatience);

  // The layer of this key (hexadecimal digits), which must have this many points where that is known; nothing
  // if it is not there.
  std::optional<CachedLayer> find(const std::string& key, std::optional<std::size_t> points);
  void store(const std::string& key, const CachedLayer& layer);
  void forget(const std::string& key);
  // Whether a layer of this key and this many points is there, whole.
  bool has(const std::string& key, std::size_t points) const;

  // Waits, with a note on standard error, for the process that has claimed this, if one has; who asks for the
  // same layers looks for them again then. `layers` of this many points are what is to be computed: more than
  // the folder may hold nobody would find, so nobody waits for them. A file system without locks (flock)
  // gives all of them their claim at once: work is done twice, and nothing is lost.
  CacheClaim claim(const std::string& key, std::size_t layers, std::size_t points);

  const std::filesystem::path& folder() const { return folder_; }
  // How many layers were found, and how many stored, as long as this object lives.
  std::size_t found_count() const { return found_; }
  std::size_t stored_count() const { return stored_; }

 private:
  std::filesystem::path file_of(const std::string& key) const;
  std::optional<CachedLayer> read(const std::string& key, std::optional<std::size_t> points) const;
  bool write(const std::filesystem::path& file, const std::string& bytes);
  void give_up(const std::string& reason);
  void remove_stale_temporaries() const;
  void keep_to_limit() const;

  std::filesystem::path folder_;
  std::uintmax_t limit_bytes_;
  std::chrono::milliseconds patience_;
  bool writes_ = true;  // until a write fails
  std::size_t found_ = 0;
  std::size_t stored_ = 0;
};

// The user's cache: in $TRUESCATTER_CACHE, else $XDG_CACHE_HOME/truescatter, else ~/.cache/truescatter, of
// $TRUESCATTER_CACHE_LIMIT_MIB (default 4096) MiB. Null, with a note on standard error, where none of these
// is set. Throws Error (input) if the limit is no whole number of 0 or more.
std::unique_ptr<TruthCache> open_user_cache();

}  // namespace truescatter
