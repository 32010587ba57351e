#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "support/error_of.h"

namespace truescatter {
namespace {

TEST(ParallelFor, VisitsEachIndexOnce) {
  constexpr std::size_t kCount = 100000;
  std::vector<std::atomic<int>> visits(kCount);
  parallel_for(kCount, [&](std::size_t i) { ++visits[i]; });
  for (std::size_t i = 0; i < kCount; ++i) ASSERT_EQ(visits[i], 1) << i;
}

TEST(ParallelFor, DoesNothingForNothing) {
  bool called = false;
  parallel_for(0, [&](std::size_t) { called = true; });
  EXPECT_FALSE(called);
}

// 4 GiB in all.
TEST(JobsWithin, IsWhatFitsAndOneAtLeast) {
  constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;
  EXPECT_EQ(jobs_within(kGiB, 16), 4);
  EXPECT_EQ(jobs_within(1.5 * kGiB, 16), 2);
  EXPECT_EQ(jobs_within(1.5 * kGiB, 1), 1);
  EXPECT_EQ(jobs_within(100.0 * kGiB, 16), 1);
  EXPECT_EQ(jobs_within(0.0, 16), 16);
}

TEST(ParallelFor, PassesAnExceptionOn) {
  const auto error = test::error_of([] {
    parallel_for(1000, [](std::size_t i) {
      if (i == 617) throw_input_error({"points.csv", 617}, "is bad");
    });
  });
  ASSERT_TRUE(error.has_value());
  EXPECT_STREQ(error->what(), "points.csv:617: is bad");
}

std::size_t threads_used() {
  std::mutex mutex;
  std::set<std::thread::id> threads;
  parallel_for(1000, [&](std::size_t) {
    const std::lock_guard lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  return threads.size();
}

TEST(JobLimit, OfOneRunsEverythingOnTheCallersThread) {
  const int before = job_count();
  {
    const JobLimit limit(1);
    EXPECT_EQ(job_count(), 1);
    EXPECT_EQ(threads_used(), 1U);
  }
  EXPECT_EQ(job_count(), before);
}

TEST(JobLimit, NeverExceedsTheLimit) {
  const JobLimit limit(2);
  EXPECT_LE(job_count(), 2);
  EXPECT_LE(threads_used(), 2U);
}

TEST(JobLimit, OfZeroMeansAllThereAre) {
  const int all = job_count();
  const JobLimit limit(0);
  EXPECT_EQ(job_count(), all);
}

}  // namespace
}  // namespace truescatter
