// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/constraint_search.h"

#include <gtest/gtest.h>

#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

/// Keyframes along a line in a room, with true depths; the last is back beside the first.
class ConstraintSearchTest : public ::testing::Test {
 protected:
  static constexpr std::int64_t last = 13;

  static SE3 world_from_camera(std::int64_t id) {
    return {SO3(), {id == last ? 0.02 : 0.01 * static_cast<double>(id), 0.0, 0.0}};
  }
  /// `error` of the last one's pose in the map; `hidden` columns of it show nothing.
  SemiDenseGraph graph_with(const SE3& error, int hidden = 0) {
    SemiDenseGraph graph(options_, true);
    for (std::int64_t id = 0; id <= last; ++id) {
      RenderedFrame frame = room_.render(world_from_camera(id));
      for (int y = 0; id == last && y < frame.gray.height(); ++y)
        for (int x = 0; x < hidden; ++x) frame.gray.at(x, y) = 60;
      const Sim3 pose(id == last ? error * world_from_camera(id) : world_from_camera(id));
      graph.add(std::make_shared<const SemiDenseKeyframe>(SemiDenseKeyframe{
                    id, id, id, frame.gray, testing::semi_dense_depth(frame, 5.0, 0.01, 1), mean_inverse_depth}),
                pose, 0);
      if (id > 0) graph.add_edge({id - 1, id, Sim3()});
    }
    return graph;
  }
  static std::vector<std::int64_t> loops_of(const std::vector<Constraint>& found) {
    std::vector<std::int64_t> ids;
    for (const Constraint& edge : found) {
      EXPECT_EQ(edge.to, last);
      if (edge.kind != ConstraintKind::loop) continue;
      const SE3 truth = world_from_camera(edge.from).inverse() * world_from_camera(last);
      EXPECT_LT((edge.rigid().inverse() * truth).log().norm(), 0.01);
      ids.push_back(edge.from);
    }
    return ids;
  }

  static constexpr double mean_inverse_depth = 0.3;
  testing::AlignmentRoom room_;
  LsdOptions options_;
  LsdSensor sensor_ = single_camera(room_.camera());
};

TEST_F(ConstraintSearchTest, KeyframesOfAnEarlierVisitHaveRoomBesideTheRecentOnes) {
  options_.near_keyframes = 2;
  const SemiDenseGraph graph = graph_with(SE3());
  ConstraintSearch search(options_, sensor_, graph, nullptr);
  const std::vector<Constraint> found = search.find(last, {});
  EXPECT_EQ(loops_of(found), (std::vector<std::int64_t>{2, 1}));
  EXPECT_EQ(found.size(), 4U);
  EXPECT_EQ(loops_of(search.find_revisited(last)), (std::vector<std::int64_t>{2, 1}));
  EXPECT_EQ(search.find_revisited(last).size(), 2U);
}

/// Of nearly all pixels, unless it is where the map expects it.
TEST_F(ConstraintSearchTest, ALoopThatMovesTheMapNeedsMoreSupport) {
  constexpr int hidden = 80;  // of 320
  const SemiDenseGraph right = graph_with(SE3(), hidden), moved = graph_with(SE3(SO3(), {0.0, 0.0, 0.25}), hidden);
  EXPECT_FALSE(loops_of(ConstraintSearch(options_, sensor_, right, nullptr).find(last, {})).empty());
  EXPECT_TRUE(loops_of(ConstraintSearch(options_, sensor_, moved, nullptr).find(last, {})).empty());
  EXPECT_TRUE(ConstraintSearch(options_, sensor_, right, nullptr).find_revisited(last).empty())
      << "a loop that was just closed is no proof of its neighbors";
  options_.loop_share = 0.6;
  EXPECT_FALSE(loops_of(ConstraintSearch(options_, sensor_, moved, nullptr).find_revisited(last)).empty());
}

/// Both alignments differ by more than they may elsewhere.
TEST_F(ConstraintSearchTest, ALoopThatTheMapConfirmsMayAgreeLessWithItsReverse) {
  const SemiDenseGraph right = graph_with(SE3()), moved = graph_with(SE3(SO3(), {0.0, 0.0, 0.25}));
  const auto finds = [&](const SemiDenseGraph& graph) {
    return !loops_of(ConstraintSearch(options_, sensor_, graph, nullptr).find(last, {})).empty();
  };
  ASSERT_TRUE(finds(moved));
  while (finds(moved) && options_.max_reciprocal_error > 1e-15) options_.max_reciprocal_error /= 2.0;
  EXPECT_TRUE(finds(right));
  options_.max_reciprocal_error = 0.0;
  EXPECT_FALSE(finds(right));
}

/// The camera came back to the first keyframe, and the last one was made of it.
TEST_F(ConstraintSearchTest, WhatWasMadeOfAnEarlierKeyframeClosesNoLoopWithIt) {
  SemiDenseGraph graph = graph_with(SE3());
  graph.add_edge({0, last, Sim3()});
  const std::vector<Constraint> found = ConstraintSearch(options_, sensor_, graph, nullptr).find(last, {});
  EXPECT_TRUE(loops_of(found).empty());
  EXPECT_FALSE(found.empty());
}

}  // namespace
}  // namespace rastro
