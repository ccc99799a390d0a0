// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_pairs.h"

#include <gtest/gtest.h>

#include <set>

#include "rastro/base/random.h"

namespace rastro {
namespace {

Trajectory at(const std::vector<TimeNs>& stamps) {
  Trajectory trajectory;
  for (const TimeNs stamp : stamps) trajectory.push_back({stamp, SE3()});
  return trajectory;
}

Trajectory every(TimeNs step, int count, TimeNs first = 0) {
  Trajectory trajectory;
  for (int k = 0; k < count; ++k) trajectory.push_back({first + k * step, SE3()});
  return trajectory;
}

constexpr TimeNs ms = 1'000'000;

TEST(TrajectoryPairs, NearestFirstAndNoneTwice) {
  // 14 is closer to 12 than 5 is; 5 is then matched with 0.
  const auto pairs = pair_by_stamp(at({0, 12}), at({5, 14}), 10);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].reference, 0u);
  EXPECT_EQ(pairs[0].estimate, 0u);
  EXPECT_EQ(pairs[1].estimate, 1u);
  const auto one = pair_by_stamp(at({10}), at({8, 11, 13}), 10);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].estimate, 1u);
}

TEST(TrajectoryPairs, TheLimitIsPartOfTheRange) {
  EXPECT_EQ(pair_by_stamp(at({0}), at({20 * ms}), 20 * ms).size(), 1u);
  EXPECT_TRUE(pair_by_stamp(at({0}), at({20 * ms + 1}), 20 * ms).empty());
  EXPECT_TRUE(pair_by_stamp({}, at({0}), 20 * ms).empty());
  EXPECT_TRUE(pair_by_stamp(at({0}), {}, 20 * ms).empty());
}

TEST(TrajectoryPairs, OffsetOfHalfAStepStillPairsMost) {
  EXPECT_GE(pair_by_stamp(every(33 * ms, 100), every(33 * ms, 100, 16'500'000), 20 * ms).size(), 66u);
}

TEST(TrajectoryPairs, RandomStampsGiveOrderedUniquePairsWithinTheLimit) {
  Random random(5);
  for (int round = 0; round < 50; ++round) {
    std::set<TimeNs> a, b;
    for (int k = 0; k < 200; ++k) {
      a.insert(static_cast<TimeNs>(random.uniform(0.0, 1000.0)));
      b.insert(static_cast<TimeNs>(random.uniform(0.0, 1000.0)));
    }
    const Trajectory reference = at({a.begin(), a.end()}), estimate = at({b.begin(), b.end()});
    const auto pairs = pair_by_stamp(reference, estimate, 20);
    EXPECT_GT(pairs.size(), 100u);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      EXPECT_LE(std::abs(reference[pairs[k].reference].stamp - estimate[pairs[k].estimate].stamp), 20);
      if (k == 0) continue;
      EXPECT_LT(pairs[k - 1].reference, pairs[k].reference);
      EXPECT_LT(pairs[k - 1].estimate, pairs[k].estimate);
    }
  }
}

double coverage(const Trajectory& reference, const Trajectory& estimate) {
  return coverage_of(reference, estimate, pair_by_stamp(reference, estimate, 20 * ms), false);
}

TEST(TrajectoryPairs, CoverageOfOneRateIsTheShareOfPoses) {
  const Trajectory reference = every(100 * ms, 100);
  EXPECT_EQ(coverage(reference, reference), 1.0);
  EXPECT_EQ(coverage(reference, every(100 * ms, 95, 500 * ms)), 0.95);
  EXPECT_EQ(coverage(reference, every(200 * ms, 50)), 0.5);  // key frames
  EXPECT_EQ(coverage_of(reference, every(1, 40), pair_by_index(reference, every(1, 40)), true), 0.4);
  EXPECT_EQ(coverage_of(reference, {}, {}, false), 0.0);
}

TEST(TrajectoryPairs, CoverageAgainstADenseReferenceIsOfTime) {
  const Trajectory reference = every(5 * ms, 2000);  // 10 s at 200 Hz
  EXPECT_NEAR(coverage(reference, every(50 * ms, 200)), 1.0, 0.002);
  EXPECT_NEAR(coverage(reference, every(50 * ms, 100)), 0.5, 0.005);
  // Key frames each half a second count for 0.12 s each.
  EXPECT_NEAR(coverage(reference, every(500 * ms, 20)), 0.24, 0.02);
}

}  // namespace
}  // namespace rastro
