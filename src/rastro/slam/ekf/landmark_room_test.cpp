// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/landmark_room.h"

#include <gtest/gtest.h>

#include "rastro/slam/ekf/filter.h"
#include "rastro/slam/ekf/observation.h"

namespace rastro {
namespace {

std::size_t bytes_with(std::size_t landmarks) {
  return EkfFilter::bytes_of(landmarks) + landmarks * sizeof(LandmarkRecord);
}

TEST(LandmarkRoom, ATwentiethIsForCandidates) {
  EkfOptions options;
  for (const auto& [most, confirmed] : {std::pair{1, 1}, {19, 19}, {20, 19}, {1000, 950}}) {
    options.max_landmarks = most;
    const LandmarkRoom room(options, 0);
    EXPECT_EQ(room.most(), static_cast<std::size_t>(most));
    EXPECT_EQ(room.most_confirmed(), static_cast<std::size_t>(confirmed));
    EXPECT_FALSE(room.limited_by_memory());
  }
}

TEST(LandmarkRoom, IsWhatFitsIntoTheMemory) {
  EkfOptions options;
  options.max_landmarks = 500;
  EXPECT_EQ(LandmarkRoom(options, bytes_with(500)).most(), 500U);
  EXPECT_FALSE(LandmarkRoom(options, bytes_with(500)).limited_by_memory());
  EXPECT_EQ(LandmarkRoom(options, bytes_with(500) - 1).most(), 499U);
  EXPECT_TRUE(LandmarkRoom(options, bytes_with(500) - 1).limited_by_memory());
  EXPECT_EQ(LandmarkRoom(options, bytes_with(1)).most(), 1U);
  EXPECT_EQ(LandmarkRoom(options, 1).most(), 0U);
}

}  // namespace
}  // namespace rastro
