// What the parts of an experiment leave to each other beside truths.
#include "experiment/kept_values.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

class KeptValuesTest : public testing::Test {
 protected:
  // Two values of the content, told apart by the number of the computation.
  std::vector<Vec4d> values(const KeptValues& shared, const std::string& content, std::size_t count = 2) {
    return shared
        .values(content, count,
                [&] {
                  ++computations_;
                  return std::vector<Vec4d>(count, Vec4d::Constant(computations_));
                })
        .values;
  }
  int computed_again(const KeptValues& shared, const std::string& content, std::size_t count = 2) {
    const int before = computations_;
    values(shared, content, count);
    return computations_ - before;
  }

  TempDir folder_;
  TruthCache cache_{folder_.path(), 1 << 20};
  int computations_ = 0;
};

TEST_F(KeptValuesTest, AreComputedByTheFirst) {
  const KeptValues first(&cache_, "program");
  const std::vector<Vec4d> computed = values(first, "a");
  EXPECT_EQ(computations_, 1);
  TruthCache others(folder_.path(), 1 << 20);
  EXPECT_EQ(values(KeptValues(&others, "program"), "a"), computed);
  EXPECT_EQ(computations_, 1);
  EXPECT_EQ(folder_.names().size(), 1U);  // no claim stays
}

TEST_F(KeptValuesTest, AreOfOneProgramAndContent) {
  const KeptValues shared(&cache_, "program");
  EXPECT_EQ(computed_again(shared, "a"), 1);
  EXPECT_EQ(computed_again(shared, "b"), 1);
  EXPECT_EQ(computed_again(KeptValues(&cache_, "another"), "a"), 1);
  EXPECT_EQ(computed_again(shared, "a"), 0);
}

TEST_F(KeptValuesTest, AreComputedEachTimeByAWholeRun) {
  EXPECT_EQ(computed_again(KeptValues(), "a"), 1);
  EXPECT_EQ(computed_again(KeptValues(), "a"), 1);
  EXPECT_TRUE(folder_.names().empty());
}

TEST_F(KeptValuesTest, AreComputedAgainWhereTheFileIsDamaged) {
  const KeptValues shared(&cache_, "program");
  values(shared, "a");
  std::filesystem::resize_file(folder_.path() / folder_.names().front(), 60);
  EXPECT_EQ(computed_again(shared, "a"), 1);
  EXPECT_EQ(computed_again(shared, "a"), 0);
}

TEST_F(KeptValuesTest, WhatThrowsKeepsNothing) {
  const KeptValues shared(&cache_, "program");
  const auto fail = [&] {
    shared.values("a", 2, []() -> std::vector<Vec4d> { throw std::runtime_error("no"); });
  };
  EXPECT_THROW(fail(), std::runtime_error);
  EXPECT_TRUE(folder_.names().empty());
  EXPECT_EQ(computed_again(shared, "a"), 1);
}

TEST_F(KeptValuesTest, KeepLayersAndPointsApart) {
  TruthValues truth(3);
  for (int l = 0; l < 3; ++l) {
    for (int i = 0; i < 2; ++i) truth[static_cast<std::size_t>(l)].push_back(Vec4d(l, i, 0.5, 1.0));
  }
  const KeptValues shared(&cache_, "program");
  const auto compute = [&] {
    ++computations_;
    return truth;
  };
  EXPECT_EQ(shared.truth_values("a", 3, 2, compute), truth);
  EXPECT_EQ(shared.truth_values("a", 3, 2, compute), truth);
  EXPECT_EQ(computations_, 1);
}

}  // namespace
}  // namespace truescatter::test
