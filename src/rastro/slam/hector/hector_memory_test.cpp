// SPDX-License-Identifier: Apache-2.0
// What a limit of the map's memory changes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "rastro/slam/hector/hector_slam.h"
#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

HectorOptions small_submaps() {
  HectorOptions options;
  options.submap_scans = 6;
  options.submap_insert_distance_m = 0.05;
  options.submap_insert_angle_rad = 0.05;
  return options;
}

/// A drive with a budget of so many bytes, 0: none.
struct LimitedDrive {
  explicit LimitedDrive(std::size_t budget) {
    HectorSlam slam(small_submaps(), nullptr, budget);
    for (const Frame& frame : testing::room_drive(100).frames()) {
      const SlamUpdate update = slam.process(frame);
      for (const SlamEvent& event : update.events) {
        if (event.kind == "memory") events.push_back(event.detail);
        key_scans += event.kind == "keyframe" ? 1 : 0;
      }
      memory.push_back(slam.map_memory());
    }
    trajectory = slam.trajectory();
  }
  std::vector<MapMemory> memory;  ///< After each scan.
  std::vector<std::string> events;
  int key_scans = 0;
  Trajectory trajectory;
};

TEST(HectorMemory, ALimitThatIsFarAwayChangesNothing) {
  const LimitedDrive free(0);
  const LimitedDrive limited(10 * free.memory.back().bytes);
  EXPECT_TRUE(limited.events.empty());
  EXPECT_EQ(limited.key_scans, free.key_scans);
  ASSERT_EQ(limited.memory.size(), free.memory.size());
  for (std::size_t k = 0; k < free.memory.size(); ++k) {
    EXPECT_EQ(limited.memory[k].bytes, free.memory[k].bytes) << k;
    EXPECT_EQ(limited.memory[k].measures, "");
  }
  EXPECT_EQ(limited.memory.back().budget_bytes, 10 * free.memory.back().bytes);
  ASSERT_EQ(limited.trajectory.size(), free.trajectory.size());
  for (std::size_t k = 0; k < free.trajectory.size(); ++k)
    EXPECT_EQ(limited.trajectory[k].world_from_body.matrix(), free.trajectory[k].world_from_body.matrix());
}

TEST(HectorMemory, FromHalfOfItOnKeyScansAreSparser) {
  const LimitedDrive free(0);
  const std::size_t budget = free.memory.back().bytes * 3 / 2;  // two thirds would be used
  const LimitedDrive limited(budget);
  EXPECT_LT(limited.key_scans, free.key_scans);
  EXPECT_GT(limited.key_scans, free.key_scans / 3);
  ASSERT_EQ(limited.events.size(), 1U);
  EXPECT_THAT(limited.events.front(), ::testing::HasSubstr(": key scans 1.5 times as sparse"));
  bool sparse = false;
  for (const MapMemory& memory : limited.memory) {
    sparse = sparse || 2 * memory.bytes >= budget;
    EXPECT_EQ(memory.measures, sparse ? "key scans 1.5 times as sparse" : "");
  }
  EXPECT_TRUE(sparse);
}

TEST(HectorMemory, AtNineTenthsWhatOthersCoverIsGivenUp) {
  const LimitedDrive free(0);
  const std::size_t budget = free.memory.back().bytes / 5;
  const LimitedDrive limited(budget);
  for (const MapMemory& memory : limited.memory) EXPECT_LE(memory.bytes, budget / 10 * 9);
  EXPECT_EQ(limited.memory.back().measures, "key scans 3 times as sparse");
  using ::testing::Contains;
  using ::testing::HasSubstr;
  EXPECT_THAT(limited.events, Contains(HasSubstr(": key scans 3 times as sparse")));
  EXPECT_THAT(limited.events, Contains(HasSubstr("the cells of a submap that others overlap were dropped")).Times(1))
      << "said once, though it happens again";
  ASSERT_EQ(limited.trajectory.size(), free.trajectory.size());
  for (std::size_t k = 0; k < free.trajectory.size(); ++k) {
    const SE3 off = limited.trajectory[k].world_from_body.inverse() * free.trajectory[k].world_from_body;
    EXPECT_LT(off.translation().norm(), 0.05) << "it is still where it was";
  }
}

}  // namespace
}  // namespace rastro
