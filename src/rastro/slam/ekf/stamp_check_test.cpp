// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/stamp_check.h"

#include <gtest/gtest.h>

#include <limits>

namespace rastro {
namespace {

using Result = StampCheck::Result;

constexpr TimeNs tick = ns_per_second / 10;

TEST(StampCheck, TimeGoesOn) {
  StampCheck check;
  for (int k = 0; k < 5; ++k) EXPECT_EQ(check.check(k * tick), Result::fits) << k;
  EXPECT_EQ(check.check(4 * tick), Result::repeated);
  EXPECT_EQ(check.check(0), Result::repeated);
  EXPECT_EQ(check.check(5 * tick), Result::fits);
}

TEST(StampCheck, OneWrongStampDoesNotStopTheRest) {
  for (const TimeNs wrong : {11 * ns_per_second, 4000 * ns_per_second, std::numeric_limits<TimeNs>::max()}) {
    StampCheck check;
    EXPECT_EQ(check.check(0), Result::fits);
    EXPECT_EQ(check.check(tick), Result::fits);
    EXPECT_EQ(check.check(wrong), Result::ahead);
    for (int k = 3; k < 6; ++k) EXPECT_EQ(check.check(k * tick), Result::fits) << k;
  }
}

TEST(StampCheck, AWrongFirstStampCostsOneFrame) {
  constexpr TimeNs begin = 1'000 * ns_per_second;
  for (const TimeNs wrong : {begin + 11 * ns_per_second, 4 * begin, std::numeric_limits<TimeNs>::max()}) {
    StampCheck check;
    EXPECT_EQ(check.check(wrong), Result::fits);
    EXPECT_EQ(check.check(begin), Result::repeated) << "one of both is wrong";
    EXPECT_EQ(check.check(begin + tick), Result::first_wrong);
    EXPECT_EQ(check.first(), begin - tick);
    for (int k = 2; k < 6; ++k) EXPECT_EQ(check.check(begin + k * tick), Result::fits) << k;
    EXPECT_EQ(check.check(begin), Result::repeated) << "a repeated frame, from now on";
  }
  StampCheck zero;
  EXPECT_EQ(zero.check(0), Result::fits);
  EXPECT_EQ(zero.check(begin), Result::ahead);
  for (int k = 1; k < 6; ++k) EXPECT_EQ(zero.check(begin + k * tick), Result::fits) << k;
}

TEST(StampCheck, ASecondFrameWithAWrongStampIsTheWrongOne) {
  constexpr TimeNs begin = 1'000 * ns_per_second;
  for (const TimeNs wrong : {TimeNs{0}, begin - 11 * ns_per_second, begin - tick, begin}) {
    StampCheck check;
    EXPECT_EQ(check.check(begin), Result::fits);
    EXPECT_EQ(check.check(wrong), Result::repeated);
    EXPECT_EQ(check.check(wrong), Result::repeated);
    for (int k = 3; k < 6; ++k) EXPECT_EQ(check.check(begin + k * tick), Result::fits) << k;
    EXPECT_EQ(check.check(0), Result::repeated);
    EXPECT_EQ(check.check(tick), Result::repeated) << "the first frames agree";
  }
}

TEST(StampCheck, AfterAPauseTheSecondFrameConfirmsTheFirst) {
  StampCheck check;
  check.check(0);
  constexpr TimeNs later = 3600 * ns_per_second;
  EXPECT_EQ(check.check(later), Result::ahead);
  EXPECT_EQ(check.check(later + tick), Result::fits);
  EXPECT_EQ(check.check(later), Result::repeated);
  EXPECT_EQ(check.check(later + 2 * tick), Result::fits);
}

TEST(StampCheck, ASlowRecordingLosesOneFrame) {
  StampCheck check;
  int lost = 0;
  for (int k = 0; k < 10; ++k) lost += check.check(k * 15 * ns_per_second) == Result::fits ? 0 : 1;
  EXPECT_EQ(lost, 1);
}

}  // namespace
}  // namespace rastro
