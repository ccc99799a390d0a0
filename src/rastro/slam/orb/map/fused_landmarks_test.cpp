// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/fused_landmarks.h"

#include <gtest/gtest.h>

#include <map>

#include "rastro/base/random.h"

namespace rastro {
namespace {

TEST(FusedLandmarks, TheLastOnesAreKnownAndThoseOfLongAgoForgotten) {
  constexpr std::int64_t least = 50, fused = 1000;
  Random random(3);
  FusedLandmarks landmarks(least);
  std::map<std::int64_t, std::int64_t> kept_of;
  std::vector<std::int64_t> order;
  for (std::int64_t k = 0; k < fused; ++k) {
    std::int64_t gone = random.below(100000);
    while (kept_of.contains(gone)) gone = random.below(100000);
    landmarks.add(gone, kept_of[gone] = k);
    order.push_back(gone);
    for (std::size_t back = 1; back <= order.size(); ++back) {
      const std::int64_t id = order[order.size() - back], found = landmarks.kept_of(id);
      if (back <= least) {
        ASSERT_EQ(found, kept_of[id]) << back << " ago";
      }
      if (back > 2 * least) {
        ASSERT_EQ(found, -1) << back << " ago";
      }
    }
  }
  EXPECT_EQ(landmarks.kept_of(-5), -1);
}

TEST(FusedLandmarks, FusedTwiceTheLastOneCounts) {
  FusedLandmarks landmarks(4);
  landmarks.add(7, 1);
  landmarks.add(7, 2);
  EXPECT_EQ(landmarks.kept_of(7), 2);
  for (const std::int64_t other : {10, 11, 12, 13}) landmarks.add(other, 0);
  EXPECT_EQ(landmarks.kept_of(7), 2) << "one of those before";
  landmarks.add(7, 3);
  EXPECT_EQ(landmarks.kept_of(7), 3);
}

}  // namespace
}  // namespace rastro
