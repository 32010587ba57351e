#include "truth/cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <random>
#include <system_error>
#include <thread>
#include <utility>

#include "core/content_hash.h"
#include "core/parse_number.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "truescatter truth 1\n";
constexpr const char* kExtension = ".truth";
constexpr const char* kTemporaryExtension = ".part";
constexpr const char* kLockExtension = ".lock";
constexpr auto kPoll = std::chrono::milliseconds(50);  // how often a claim that another has is looked at
constexpr auto kSign = std::chrono::seconds(5);        // how often who has one shows a sign of life
constexpr auto kStaleAge = std::chrono::hours(1);
constexpr std::uintmax_t kMiB = 1U << 20U;
constexpr int kDefaultLimitMiB = 4096;

void note(const fs::path& path, const std::string& text) {
  fmt::print(stderr, "note: {}: {}\n", path.string(), text);
}

// What follows the magic: points, seconds, a checksum of the key and of all but itself, and the values, in
// the machine's own byte order.
struct Header {
  std::uint64_t points = 0;
  double seconds = 0.0;
  std::array<char, 40> checksum{};
};
static_assert(sizeof(Header) == 56);

std::array<char, 40> checksum_of(const std::string& key, const Header& header, const Vec4d* values) {
  ContentHash hash;
  hash.append(key);
  hash.append(header.points);
  hash.append(header.seconds);
  hash.append(values, header.points * sizeof(Vec4d));
  const std::string digits = hash.hex();
  std::array<char, 40> checksum{};
  std::copy(digits.begin(), digits.end(), checksum.begin());
  return checksum;
}

std::string to_bytes(const std::string& key, const CachedLayer& layer) {
  Header header{layer.values.size(), layer.seconds, {}};
  header.checksum = checksum_of(key, header, layer.values.data());
  std::string bytes(kMagic);
  bytes.append(reinterpret_cast<const char*>(&header), sizeof(header));
  bytes.append(reinterpret_cast<const char*>(layer.values.data()), layer.values.size() * sizeof(Vec4d));
  return bytes;
}

std::size_t file_size_of(std::size_t points) {
  return kMagic.size() + sizeof(Header) + points * sizeof(Vec4d);
}

// Nothing if the bytes are not what to_bytes wrote.
std::optional<CachedLayer> from_bytes(const std::string& key, std::size_t points, const std::string& bytes) {
  if (bytes.size() != file_size_of(points)) return std::nullopt;
  if (!bytes.starts_with(kMagic)) return std::nullopt;
  Header header;
  std::memcpy(&header, bytes.data() + kMagic.size(), sizeof(header));
  if (header.points != points) return std::nullopt;
  CachedLayer layer{std::vector<Vec4d>(points), header.seconds};
  std::memcpy(static_cast<void*>(layer.values.data()), bytes.data() + kMagic.size() + sizeof(header),
              points * sizeof(Vec4d));
  if (header.checksum != checksum_of(key, header, layer.values.data())) return std::nullopt;
  return layer;
}

std::string reason_of(int error) { return std::generic_category().message(error); }

// A new file of a name that begins so, open for writing; -1, with the errno: there is none. Unlike mkostemps
// this leaves it to the user's umask who may read it: a cache may be several users'.
int make_temporary(const fs::path& start, std::string& name) {
  std::random_device random;
  while (true) {
    name = fmt::format("{}.{:08x}{}", start.string(), random(), kTemporaryExtension);
    const int descriptor = open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
  }
}

// The claim's file, of whoever made it; -1: it cannot be opened.
int open_claim(const fs::path& file) {
  const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  return descriptor >= 0 || errno != EACCES ? descriptor : open(file.c_str(), O_RDONLY | O_CLOEXEC);
}

// Writes everything and closes; 0, or the errno.
int write_and_close(int descriptor, const std::string& bytes) {
  int error = 0;
  std::size_t done = 0;
  while (done < bytes.size() && error == 0) {
    const ssize_t written = ::write(descriptor, bytes.data() + done, bytes.size() - done);
    if (written > 0) {
      done += static_cast<std::size_t>(written);
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

// `use(path)` for each entry, whatever others do to the folder meanwhile.
template <typename Use>
void for_entries(const fs::path& folder, const Use& use) {
  std::error_code failure;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
    use(it->path());
}

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Whether a file still has its name.
bool is_at(int descriptor, const fs::path& path) {
  struct stat open_file {};
  struct stat named {};
  return fstat(descriptor, &open_file) == 0 && stat(path.c_str(), &named) == 0 &&
         open_file.st_dev == named.st_dev && open_file.st_ino == named.st_ino;
}

timespec changed_at(int descriptor) {
  struct stat file {};
  return fstat(descriptor, &file) == 0 ? file.st_mtim : timespec{};
}

// Whether the file could be locked: not where there are no locks, and not where its holder shows no sign of
// life for as long as `patience`, by this machine's clock alone. EWOULDBLOCK alone means that another process
// has it.
bool lock_when_free(int descriptor, const fs::path& path, std::chrono::milliseconds patience) {
  using Clock = std::chrono::steady_clock;
  bool said = false;
  timespec sign = changed_at(descriptor);
  Clock::time_point signed_at = Clock::now();
  while (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EINTR) continue;
    if (errno != EWOULDBLOCK) return false;
    if (!std::exchange(said, true)) note(path, "another process computes this truth; waiting for it");
    std::this_thread::sleep_for(kPoll);
    const timespec now = changed_at(descriptor);
    if (now.tv_sec != sign.tv_sec || now.tv_nsec != sign.tv_nsec) {
      sign = now;
      signed_at = Clock::now();
    } else if (Clock::now() - signed_at > patience) {
      note(path, "the process that computes this truth shows no sign of life; computing it here too");
      return false;
    }
  }
  return true;
}

}  // namespace

// Changes the time of a file that is open now and then.
class CacheClaim::Sign {
 public:
  explicit Sign(int descriptor) : thread_([this, descriptor] { give(descriptor); }) {}
  Sign(const Sign&) = delete;
  Sign& operator=(const Sign&) = delete;
  ~Sign() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

 private:
  void give(int descriptor) {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, kSign, [this] { return ended_; })) futimens(descriptor, nullptr);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::thread thread_;
};

CacheClaim::CacheClaim(int descriptor, fs::path file)
    : descriptor_(descriptor), file_(std::move(file)), sign_(std::make_unique<Sign>(descriptor)) {}

CacheClaim::CacheClaim() noexcept = default;

CacheClaim::CacheClaim(CacheClaim&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      file_(std::move(other.file_)),
      sign_(std::move(other.sign_)) {}

CacheClaim& CacheClaim::operator=(CacheClaim&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(file_, other.file_);
  std::swap(sign_, other.sign_);
  return *this;
}

CacheClaim::~CacheClaim() {
  if (descriptor_ < 0) return;
  sign_.reset();
  unlink(file_.c_str());  // while it is locked: who waits for it finds that the name is gone
  close(descriptor_);
}

TruthCache::TruthCache(fs::path folder, std::uintmax_t limit_bytes, std::chrono::milliseconds patience)
    : folder_(std::move(folder)), limit_bytes_(limit_bytes), patience_(patience) {}

fs::path TruthCache::file_of(const std::string& key) const { return folder_ / (key + kExtension); }

std::optional<CachedLayer> TruthCache::read(const std::string& key, std::optional<std::size_t> points) const {
  std::ifstream stream(file_of(key), std::ios::binary | std::ios::ate);
  if (!stream) return std::nullopt;
  const auto size = static_cast<std::uintmax_t>(static_cast<std::streamoff>(stream.tellg()));
  // What is of another size is damaged, however large it is.
  if (!points && (size < file_size_of(0) || size > limit_bytes_)) return std::nullopt;
  if (!points) points = (size - file_size_of(0)) / sizeof(Vec4d);
  if (size != file_size_of(*points)) return std::nullopt;
  std::string bytes(file_size_of(*points), '\0');
  stream.seekg(0);
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return stream ? from_bytes(key, *points, bytes) : std::nullopt;
}

std::optional<CachedLayer> TruthCache::find(const std::string& key, std::optional<std::size_t> points) {
  const fs::path file = file_of(key);
  if (access(file.c_str(), R_OK) != 0) return std::nullopt;  // none, or another user's own
  std::optional<CachedLayer> layer = read(key, points);
  if (layer) {
    ++found_;
    std::error_code failure;
    fs::last_write_time(file, fs::file_time_type::clock::now(), failure);  // for the least recently used
    return layer;
  }
  forget(key);
  note(file, "this cached truth is damaged; it is computed again");
  return std::nullopt;
}

void TruthCache::forget(const std::string& key) {
  std::error_code failure;
  fs::remove(file_of(key), failure);
}

bool TruthCache::has(const std::string& key, std::size_t points) const {
  return read(key, points).has_value();
}

CacheClaim TruthCache::claim(const std::string& key, std::size_t layers, std::size_t points) {
  // What is computed meanwhile would not be found here.
  if (!writes_ || static_cast<double>(layers) * static_cast<double>(file_size_of(points)) >
                      static_cast<double>(limit_bytes_))
    return {};
  std::error_code failure;
  fs::create_directories(folder_, failure);
  const fs::path file = folder_ / ("." + key + kLockExtension);
  while (true) {
    const int descriptor = open_claim(file);
    if (descriptor < 0) return {};
    const bool locked = lock_when_free(descriptor, file, patience_);
    if (locked && is_at(descriptor, file)) return {descriptor, file};
    // The name is not this file's, or not this process's: neither is it this one's to remove.
    close(descriptor);
    if (!locked) return {};
  }
}

void TruthCache::store(const std::string& key, const CachedLayer& layer) {
  if (!writes_) return;
  const std::string bytes = to_bytes(key, layer);
  if (bytes.size() > limit_bytes_) return;
  std::error_code failure;
  fs::create_directories(folder_, failure);
  if (failure) return give_up(failure.message());
  remove_stale_temporaries();
  if (!write(file_of(key), bytes)) return;
  ++stored_;
  keep_to_limit();
}

bool TruthCache::write(const fs::path& file, const std::string& bytes) {
  std::string temporary;
  const int descriptor = make_temporary(folder_ / fmt::format(".{}", file.stem().string()), temporary);
  if (descriptor < 0) {
    give_up(reason_of(errno));
    return false;
  }
  int error = write_and_close(descriptor, bytes);
  if (error == 0 && std::rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error == 0) return true;
  unlink(temporary.c_str());
  give_up(reason_of(error));
  return false;
}

void TruthCache::give_up(const std::string& reason) {
  writes_ = false;
  note(folder_, "truths cannot be cached here: " + reason);
}

void TruthCache::remove_stale_temporaries() const {
  for_entries(folder_, [&](const fs::path& entry) {
    const std::string name = entry.filename().string();
    const bool is_claim = name.ends_with(kLockExtension);
    if (!name.starts_with('.') || (!is_claim && !name.ends_with(kTemporaryExtension))) return;
    std::error_code failure;
    const auto written = fs::last_write_time(entry, failure);
    if (failure || fs::file_time_type::clock::now() - written < kStaleAge) return;
    if (!is_claim) {
      fs::remove(entry, failure);
    } else if (const int descriptor = open(entry.c_str(), O_RDWR | O_CLOEXEC); descriptor >= 0) {
      // As who has it would, if somebody had.
      if (flock(descriptor, LOCK_EX | LOCK_NB) == 0 && is_at(descriptor, entry)) unlink(entry.c_str());
      close(descriptor);
    }
  });
}

void TruthCache::keep_to_limit() const {
  struct Entry {
    fs::file_time_type used;
    std::uintmax_t bytes;
    fs::path path;
  };
  std::vector<Entry> entries;
  std::uintmax_t total = 0;
  for_entries(folder_, [&](const fs::path& path) {
    if (path.extension() != kExtension) return;
    std::error_code gone;
    const std::uintmax_t bytes = fs::file_size(path, gone);
    if (gone) return;
    const fs::file_time_type used = fs::last_write_time(path, gone);
    if (gone) return;
    entries.push_back({used, bytes, path});
    total += bytes;
  });
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.used != b.used ? a.used < b.used : a.path < b.path;
  });
  for (const Entry& entry : entries) {
    if (total <= limit_bytes_) break;
    std::error_code failure;
    fs::remove(entry.path, failure);
    total -= entry.bytes;
  }
}

std::unique_ptr<TruthCache> open_user_cache() {
  const std::string limit = variable("TRUESCATTER_CACHE_LIMIT_MIB");
  const SourceLocation where{"TRUESCATTER_CACHE_LIMIT_MIB"};
  const int limit_mib = limit.empty() ? kDefaultLimitMiB : parse_integer(limit, where, "a limit in MiB");
  if (limit_mib < 0) throw_input_error(where, "\"{}\": a limit in MiB must be 0 or more", limit);
  fs::path folder = variable("TRUESCATTER_CACHE");
  if (folder.empty() && !variable("XDG_CACHE_HOME").empty())
    folder = fs::path(variable("XDG_CACHE_HOME")) / "truescatter";
  if (folder.empty() && !variable("HOME").empty())
    folder = fs::path(variable("HOME")) / ".cache" / "truescatter";
  if (folder.empty()) {
    fmt::print(stderr, "note: truths are not cached: no TRUESCATTER_CACHE, XDG_CACHE_HOME or HOME is set\n");
    return nullptr;
  }
  return std::make_unique<TruthCache>(std::move(folder), static_cast<std::uintmax_t>(limit_mib) * kMiB);
}

}  // namespace truescatter
