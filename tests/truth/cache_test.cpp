#include "truth/cache.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <random>

#include "core/file.h"
#include "support/environment.h"
#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;
using test::EnvironmentVariable;
using test::error_of;
using test::TempDir;

constexpr std::uintmax_t kPlenty = 1 << 30;
const std::string kKey = "0123456789abcdef0123456789abcdef01234567";

CachedLayer layer_of(std::size_t points, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  CachedLayer layer{{}, 0.1 * static_cast<double>(seed)};
  for (std::size_t i = 0; i < points; ++i) {
    Vec4d value;
    for (int c = 0; c < 4; ++c) value[c] = static_cast<double>(generator()) * 1e-19 - 0.5;
    layer.values.push_back(value);
  }
  return layer;
}

void expect_same(const std::optional<CachedLayer>& found, const CachedLayer& stored) {
  ASSERT_TRUE(found);
  EXPECT_EQ(found->values, stored.values);
  EXPECT_EQ(found->seconds, stored.seconds);
}

class TruthCacheTest : public testing::Test {
 protected:
  fs::path file(const std::string& key = kKey) const { return folder_.path() / (key + ".truth"); }

  TempDir folder_;
  TruthCache cache_{folder_.path(), kPlenty};
};

TEST_F(TruthCacheTest, GivesBackEveryBit) {
  const CachedLayer layer = layer_of(100, 7);
  EXPECT_FALSE(cache_.find(kKey, 100));
  cache_.store(kKey, layer);
  expect_same(cache_.find(kKey, 100), layer);
  expect_same(TruthCache(folder_.path(), kPlenty).find(kKey, 100), layer);
  EXPECT_EQ(folder_.names(), std::vector<std::string>{kKey + ".truth"});
  cache_.forget(kKey);
  EXPECT_FALSE(cache_.find(kKey, 100));
}

// Of however many points where nobody knows: but whole, and no larger than the folder may be.
TEST_F(TruthCacheTest, FindsALayerOfAnyLength) {
  const CachedLayer layer = layer_of(100, 7);
  EXPECT_FALSE(cache_.find(kKey, std::nullopt));
  cache_.store(kKey, layer);
  expect_same(cache_.find(kKey, std::nullopt), layer);
  TruthCache small(folder_.path(), 100 * sizeof(Vec4d));
  EXPECT_FALSE(small.find(kKey, std::nullopt));
  EXPECT_FALSE(fs::exists(file()));
  for (const std::uintmax_t bytes : {0U, 10U, 76U, 77U, 100U * 32U, 101U * 32U + 76U}) {
    cache_.store(kKey, layer);
    fs::resize_file(file(), bytes);
    EXPECT_FALSE(cache_.find(kKey, std::nullopt)) << bytes;
  }
}

TEST_F(TruthCacheTest, MakesItsFolder) {
  const fs::path deep = folder_.path() / "a" / "b";
  TruthCache cache(deep, kPlenty);
  EXPECT_FALSE(cache.find(kKey, 3));
  EXPECT_FALSE(fs::exists(deep));
  cache.store(kKey, layer_of(3, 1));
  expect_same(cache.find(kKey, 3), layer_of(3, 1));
}

// A file of another key (renamed), of another number of points, cut off anywhere, with a byte too many, or
// with any bit turned is not taken for good; it is said, once, and makes room.
TEST_F(TruthCacheTest, IgnoresAndRemovesADamagedFile) {
  const CachedLayer layer = layer_of(4, 3);
  cache_.store(kKey, layer);
  const std::string good = read_text_file(file());
  const auto expect_refused = [&](const std::string& bytes, std::size_t points) {
    folder_.write(file().filename().string(), bytes);
    testing::internal::CaptureStderr();
    EXPECT_FALSE(cache_.find(kKey, points));
    EXPECT_FALSE(cache_.find(kKey, points));
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "note: " + file().string() + ": this cached truth is damaged; it is computed again\n");
    EXPECT_FALSE(fs::exists(file()));
  };
  for (std::size_t length = 0; length < good.size(); ++length) expect_refused(good.substr(0, length), 4);
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string turned = good;
    turned[i] = static_cast<char>(turned[i] ^ 0x10);
    expect_refused(turned, 4);
  }
  expect_refused(good + "x", 4);
  expect_refused(good, 5);
  const std::string other = "f" + kKey.substr(1);
  cache_.store(other, layer);
  expect_refused(read_text_file(file(other)), 4);
  // And what replaces it is good again.
  cache_.store(kKey, layer);
  expect_same(cache_.find(kKey, 4), layer);
}

// 100 points take 3200 bytes and a little more: three layers fit into 10 500 bytes, four do not. What was
// read counts as used.
TEST_F(TruthCacheTest, RemovesWhatWasUsedLeastRecently) {
  TruthCache small(folder_.path(), 10500);
  const auto key = [](char digit) { return std::string(40, digit); };
  const auto age = [&](char digit, int hours) {
    fs::last_write_time(file(key(digit)), fs::file_time_type::clock::now() - std::chrono::hours(hours));
  };
  for (const char digit : {'1', '2', '3'}) small.store(key(digit), layer_of(100, 1));
  age('1', 30);
  age('2', 20);
  age('3', 10);
  ASSERT_TRUE(small.find(key('1'), 100));
  small.store(key('4'), layer_of(100, 1));
  EXPECT_TRUE(fs::exists(file(key('1'))));
  EXPECT_FALSE(fs::exists(file(key('2'))));
  EXPECT_TRUE(fs::exists(file(key('3'))));
  EXPECT_TRUE(fs::exists(file(key('4'))));
  // What does not fit at all drives nothing out.
  small.store(key('5'), layer_of(1000, 1));
  EXPECT_FALSE(fs::exists(file(key('5'))));
  EXPECT_EQ(folder_.names().size(), 3U);
}

TEST_F(TruthCacheTest, RemovesTemporariesOfTheDead) {
  const fs::path old = folder_.write("." + kKey + ".aBcDeF.part", "half a lay");
  const fs::path fresh = folder_.write("." + kKey + ".gHiJkL.part", "half a lay");
  fs::last_write_time(old, fs::file_time_type::clock::now() - std::chrono::hours(2));
  cache_.store(kKey, layer_of(3, 1));
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(fresh));  // its process may be alive
}

// A folder below a file cannot be made, whoever runs the test. It is said once.
// A lock belongs to an open file, so another one of this process stands for another process: one that shows
// no sign of life.
TEST_F(TruthCacheTest, DoesNotWaitForAClaimWithoutASignOfLife) {
  using std::chrono::milliseconds;
  TruthCache cache(folder_.path(), kPlenty, milliseconds(200));
  { const CacheClaim free = cache.claim(kKey, 1, 10); }
  const fs::path lock = folder_.path() / ("." + kKey + ".lock");
  EXPECT_FALSE(fs::exists(lock));
  const int held = open(lock.c_str(), O_RDWR | O_CREAT, 0666);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  testing::internal::CaptureStderr();
  const auto begin = std::chrono::steady_clock::now();
  { const CacheClaim none = cache.claim(kKey, 1, 10); }
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(200));
  EXPECT_NE(testing::internal::GetCapturedStderr().find("shows no sign of life"), std::string::npos);
  EXPECT_TRUE(fs::exists(lock));  // it is not its own to remove
  // Of more than the cache may hold nobody would find anything.
  { const CacheClaim unbounded = TruthCache(folder_.path(), 1000, milliseconds(100000)).claim(kKey, 1, 100); }
  close(held);
}

TEST_F(TruthCacheTest, HasWhatIsWholeAlone) {
  EXPECT_FALSE(cache_.has(kKey, 7));
  cache_.store(kKey, layer_of(7, 1));
  EXPECT_TRUE(cache_.has(kKey, 7));
  EXPECT_FALSE(cache_.has(kKey, 8));
  std::string bytes = read_text_file(file());
  bytes.back() ^= 1;
  write_text_file(file(), bytes);
  EXPECT_FALSE(cache_.has(kKey, 7));
  EXPECT_TRUE(fs::exists(file()));
}

TEST_F(TruthCacheTest, LetsOthersReadAsTheUmaskHasIt) {
  const mode_t before = umask(0027);
  cache_.store(kKey, layer_of(7, 1));
  umask(before);
  EXPECT_EQ(fs::status(file()).permissions(), fs::perms(0640));
}

TEST_F(TruthCacheTest, WarnsOnceWhereItCannotWrite) {
  const fs::path below = folder_.write("a-file", "") / "cache";
  TruthCache cache(below, kPlenty);
  testing::internal::CaptureStderr();
  EXPECT_FALSE(cache.find(kKey, 3));
  cache.store(kKey, layer_of(3, 1));
  cache.store(kKey, layer_of(3, 1));
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(said.starts_with("note: " + below.string() + ": truths cannot be cached here: ")) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
}

// Runs `body` in a process of its own; its exit status, 0 if it returns true.
template <typename Body>
pid_t in_a_process(const Body& body) {
  const pid_t child = fork();
  if (child == 0) _exit(body() ? 0 : 1);
  return child;
}

int status_of(pid_t child) {
  int status = -1;
  waitpid(child, &status, 0);
  return status;
}

// No file may grow beyond 1000 bytes, as on a full disk: the earlier layer stays, nothing is left beside it.
TEST_F(TruthCacheTest, LeavesNothingOnAFullDisk) {
  cache_.store(kKey, layer_of(3, 1));
  const pid_t child = in_a_process([&] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0 || freopen("/dev/null", "w", stderr) == nullptr) return false;
    cache_.store(kKey, layer_of(1000, 2));
    return true;
  });
  EXPECT_EQ(status_of(child), 0);
  expect_same(cache_.find(kKey, 3), layer_of(3, 1));
  EXPECT_EQ(folder_.names().size(), 1U);
}

// Processes that write and read the same keys at once find whole layers or none.
TEST_F(TruthCacheTest, ServesProcessesAtOnce) {
  const auto key = [](int k) { return std::string(40, static_cast<char>('a' + k)); };
  const auto work = [&](int first) {
    TruthCache cache(folder_.path(), kPlenty);
    for (int round = 0; round < 300; ++round) {
      const int k = (first + round) % 3;
      const CachedLayer layer = layer_of(200, static_cast<std::uint64_t>(k));
      cache.store(key(k), layer);
      const std::optional<CachedLayer> found = cache.find(key((k + 1) % 3), 200);
      if (found && found->values != layer_of(200, static_cast<std::uint64_t>((k + 1) % 3)).values)
        return false;
    }
    return true;
  };
  std::vector<pid_t> children;
  for (int i = 0; i < 3; ++i) children.push_back(in_a_process([&] { return work(i); }));
  for (const pid_t child : children) EXPECT_EQ(status_of(child), 0);
  for (int k = 0; k < 3; ++k)
    expect_same(cache_.find(key(k), 200), layer_of(200, static_cast<std::uint64_t>(k)));
  EXPECT_EQ(folder_.names().size(), 3U);
}

// A process is killed while it writes again and again: what is found is whole, and its temporary, if it left
// one, hinders nobody.
TEST_F(TruthCacheTest, SurvivesAKilledWriter) {
  const CachedLayer layer = layer_of(20000, 5);
  for (int round = 0; round < 10; ++round) {
    const pid_t child = in_a_process([&] {
      while (true) cache_.store(kKey, layer);
      return true;
    });
    while (!fs::exists(file())) usleep(1000);
    usleep(static_cast<useconds_t>(1000 * round));
    kill(child, SIGKILL);
    EXPECT_TRUE(WIFSIGNALED(status_of(child)));
    expect_same(cache_.find(kKey, 20000), layer);
  }
  cache_.store(kKey, layer);
  expect_same(cache_.find(kKey, 20000), layer);
}

TEST(UserCache, LiesWhereTheEnvironmentSays) {
  const auto folder = [](const std::optional<std::string>& own, const std::optional<std::string>& xdg,
                         const std::optional<std::string>& home) {
    const EnvironmentVariable a("TRUESCATTER_CACHE", own);
    const EnvironmentVariable b("XDG_CACHE_HOME", xdg);
    const EnvironmentVariable c("HOME", home);
    const std::unique_ptr<TruthCache> cache = open_user_cache();
    return cache ? cache->folder().string() : "none";
  };
  EXPECT_EQ(folder("/own", "/xdg", "/home/me"), "/own");
  EXPECT_EQ(folder(std::nullopt, "/xdg", "/home/me"), "/xdg/truescatter");
  EXPECT_EQ(folder("", "/xdg", "/home/me"), "/xdg/truescatter");
  EXPECT_EQ(folder(std::nullopt, "", "/home/me"), "/home/me/.cache/truescatter");
  EXPECT_EQ(folder(std::nullopt, std::nullopt, std::nullopt), "none");
}

TEST(UserCache, HasALimitFromTheEnvironment) {
  const TempDir folder;
  const EnvironmentVariable own("TRUESCATTER_CACHE", folder.path().string());
  {
    const EnvironmentVariable none("TRUESCATTER_CACHE_LIMIT_MIB", "0");
    open_user_cache()->store(kKey, layer_of(3, 1));
    EXPECT_TRUE(folder.names().empty());
  }
  const EnvironmentVariable one("TRUESCATTER_CACHE_LIMIT_MIB", "1");
  open_user_cache()->store(kKey, layer_of(3, 1));
  EXPECT_EQ(folder.names().size(), 1U);
  for (const char* wrong : {"-1", "many", "1.5"}) {
    const EnvironmentVariable bad("TRUESCATTER_CACHE_LIMIT_MIB", wrong);
    const std::optional<Error> error = error_of([] { open_user_cache(); });
    ASSERT_TRUE(error) << wrong;
    EXPECT_EQ(error->kind(), ErrorKind::input);
    EXPECT_TRUE(std::string(error->what()).starts_with("TRUESCATTER_CACHE_LIMIT_MIB: ")) << error->what();
  }
}

}  // namespace
}  // namespace truescatter
