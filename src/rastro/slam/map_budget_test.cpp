// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/map_budget.h"

#include <gtest/gtest.h>

#include <utility>

namespace rastro {
namespace {

TEST(MapBudget, StagesBeginAtHalfThreeQuartersAndNineTenths) {
  MapBudget budget(1000);
  EXPECT_EQ(budget.full_bytes(), 900U);
  const std::pair<std::size_t, int> fills[] = {{0, 0}, {499, 0}, {500, 1}, {749, 1}, {750, 2}, {899, 2}, {900, 3}};
  int before = 0;
  for (const auto& [bytes, stage] : fills) {
    EXPECT_EQ(budget.note(bytes), stage > before) << bytes;
    EXPECT_EQ(budget.stage(), stage) << bytes;
    before = stage;
  }
  EXPECT_FALSE(budget.note(5000)) << "there is no fourth stage";
  EXPECT_FALSE(budget.note(10));
  EXPECT_EQ(budget.stage(), 3) << "a stage never falls";
}

TEST(MapBudget, EachStageIsMoreSparing) {
  const std::pair<double, double> expected[] = {{1.0, 1.0}, {1.5, 0.75}, {2.0, 0.5}, {3.0, 0.35}};
  const std::size_t fills[] = {0, 60, 80, 95};
  for (std::size_t stage = 0; stage < 4; ++stage) {
    MapBudget budget(100);
    budget.note(fills[stage]);
    EXPECT_EQ(budget.spacing(), expected[stage].first);
    EXPECT_EQ(budget.share(), expected[stage].second);
  }
}

TEST(MapBudget, WithoutALimitNothingIsSaved) {
  MapBudget budget;
  EXPECT_FALSE(budget.limited());
  EXPECT_FALSE(budget.note(1000000));
  EXPECT_EQ(budget.stage(), 0);
}

TEST(MapBudget, ComesFromTheMapsOwnLimitOrWhatTheProgramLeaves) {
  SlamContext context;
  EXPECT_EQ(map_budget_bytes(context, 150.0), 0U);
  context.max_memory_bytes = 400000000;
  EXPECT_EQ(map_budget_bytes(context, 150.0), 250000000U);
  EXPECT_EQ(map_budget_bytes(context, 390.0), 16000000U) << "at least 16 MB";
  EXPECT_EQ(map_budget_bytes(context, 500.0), 16000000U);
  context.map_memory_bytes = 7000000;
  EXPECT_EQ(map_budget_bytes(context, 150.0), 7000000U);
}

TEST(MapBudget, ItsEventTellsHowFullTheMapIs) {
  const SlamEvent event = MapBudget(20000000).event(15000000, "fewer keyframes");
  EXPECT_EQ(event.kind, "memory");
  EXPECT_EQ(event.detail, "the map uses 75 % of its 20.0 MB: fewer keyframes");
}

}  // namespace
}  // namespace rastro
