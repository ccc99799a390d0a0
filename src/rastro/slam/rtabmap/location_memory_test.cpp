// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/rtabmap/location_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rastro {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Locations 0, 10, 20, ... one after the other, all in working memory.
LocationMemory memory_of(int locations) {
  LocationMemory memory;
  for (int i = 0; i < locations; ++i) memory.begin(10 * i, {i}, i > 0);
  while (memory.leave_short_term(0)) continue;
  memory.take_reweighted();
  return memory;
}

TEST(LocationMemory, ShortTermMemoryGivesItsOldestWhenItIsTooLong) {
  LocationMemory memory;
  for (std::int64_t id = 0; id < 3; ++id) {
    memory.begin(id, {}, true);
    EXPECT_EQ(memory.leave_short_term(3), std::nullopt);
  }
  memory.begin(3, {}, true);
  EXPECT_EQ(memory.leave_short_term(3), 0);
  EXPECT_EQ(memory.leave_short_term(3), std::nullopt);
  EXPECT_EQ(memory.at(0).stage, MemoryStage::working);
  EXPECT_EQ(memory.at(1).stage, MemoryStage::short_term);
  EXPECT_THAT(memory.working(), ElementsAre(0));
}

TEST(LocationMemory, RehearsalAddsWeightToTheLastLocation) {
  LocationMemory memory = memory_of(2);
  memory.rehearse(11);
  memory.rehearse(12);
  EXPECT_EQ(memory.at(10).weight, 3.0);
  EXPECT_EQ(memory.at(0).weight, 1.0);
  EXPECT_EQ(memory.location_of(12), 10);
  EXPECT_THAT(memory.at(10).keyframes, ElementsAre(10, 11, 12));
  EXPECT_THAT(memory.take_reweighted(), ElementsAre(10));
  EXPECT_THAT(memory.take_reweighted(), IsEmpty());
}

TEST(LocationMemory, ConsecutiveLocationsAreNeighborsUnlessTheCameraWasLost) {
  LocationMemory memory = memory_of(2);
  memory.begin(20, {}, false);
  EXPECT_THAT(memory.at(0).neighbors, ElementsAre(10));
  EXPECT_THAT(memory.at(10).neighbors, ElementsAre(0));
  EXPECT_THAT(memory.at(20).neighbors, IsEmpty());
}

TEST(LocationMemory, AClosedLoopGivesTheWeightToTheNewerLocation) {
  LocationMemory memory = memory_of(4);
  memory.rehearse(31);
  memory.close_loop(30, 0);
  EXPECT_EQ(memory.at(30).weight, 3.0);
  EXPECT_EQ(memory.at(0).weight, 0.0);
  EXPECT_THAT(memory.at(0).neighbors, ElementsAre(10, 30));
  EXPECT_THAT(memory.at(30).neighbors, ElementsAre(20, 0));
  memory.link(30, 0);
  EXPECT_THAT(memory.at(30).neighbors, ElementsAre(20, 0)) << "once";
  memory.link(30, 30);
  EXPECT_THAT(memory.at(30).neighbors, ElementsAre(20, 0)) << "not of itself";
}

TEST(LocationMemory, TheLightestThenOldestIsTheLeast) {
  LocationMemory memory = memory_of(4);
  EXPECT_EQ(memory.least({}), 0);
  memory.weigh(20, 0.5);
  EXPECT_EQ(memory.least({}), 20);
  EXPECT_EQ(memory.least({20}), 0);
  EXPECT_EQ(memory.least({0, 10, 20, 30}), std::nullopt);
  memory.transfer(20);
  memory.transfer(0);
  EXPECT_EQ(memory.least({}), 10) << "what is in long-term memory is not there to be transferred";
  memory.retrieve(0);
  EXPECT_EQ(memory.least({}), 10) << "of equal weight, the one that came back is the newer one";
  EXPECT_EQ(memory.least({10, 30}), 0);
}

TEST(LocationMemory, ForgottenNeighborsAreTheNearestFirst) {
  LocationMemory memory = memory_of(6);
  for (const std::int64_t id : {0, 10, 30, 50}) memory.transfer(id);
  EXPECT_THAT(memory.forgotten_neighbors(20, 2, 9), ElementsAre(10, 30, 0));
  EXPECT_THAT(memory.forgotten_neighbors(20, 1, 9), ElementsAre(10, 30));
  EXPECT_THAT(memory.forgotten_neighbors(20, 3, 9), ElementsAre(10, 30, 0, 50));
  EXPECT_THAT(memory.forgotten_neighbors(20, 3, 2), ElementsAre(10, 30));
  EXPECT_THAT(memory.forgotten_neighbors(20, 3, 0), IsEmpty());
  EXPECT_THAT(memory.forgotten_neighbors(20, 0, 9), IsEmpty());
}

}  // namespace
}  // namespace rastro
