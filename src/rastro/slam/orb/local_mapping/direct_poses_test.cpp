// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/direct_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "rastro/slam/orb/local_mapping/bundle_problem.h"
#include "rastro/slam/orb/local_mapping/mapping_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::mapping_pose;
using testing::PointWorld;

struct NumberedView : DirectView {
  explicit NumberedView(int a_number) : number(a_number) {}
  std::size_t bytes() const override { return sizeof(*this); }
  int number;
};

/// Knows every pose but that of view 2.
class ExactAlignment : public DirectAlignment {
 public:
  std::shared_ptr<const DirectView> view_of(const Frame&, const SE3&) const override { return nullptr; }
  std::shared_ptr<const DirectView> keyframe_of(const DirectView& view) const override {
    return std::make_shared<NumberedView>(static_cast<const NumberedView&>(view));
  }
  std::optional<RelativePose> align(const DirectView& keyframe, const DirectView& view, const SE3&) const override {
    const int from = static_cast<const NumberedView&>(keyframe).number,
              to = static_cast<const NumberedView&>(view).number;
    if (from == 2 || to == 2) return std::nullopt;
    return RelativePose{mapping_pose(to) * mapping_pose(from).inverse(), 1e-8 * Matrix6d::Identity()};
  }
};

/// Keyframe 7 of a map in which each shares most landmarks with the one before.
struct AlignedBench {
  AlignedBench() {
    for (int id = 0; id < 8; ++id) {
      map.add(id, mapping_pose(id), {.from = 20 * static_cast<std::uint32_t>(id)});
      poses.add(id, NumberedView(id));
    }
    poses.connect(7);
  }

  PointWorld world{250, 11};
  ExactMap map{world, CameraKind::depth, 0.1};
  ExactAlignment alignment;
  struct Poses : DirectPoses {
    using DirectPoses::DirectPoses;
    void add(std::int64_t id, const NumberedView& view) { DirectPoses::add(id, &view); }
  } poses{&alignment, map.graph};
};

TEST(DirectPoses, AreWithTheKeyframesThatShareMostAndTheOldestBothWays) {
  AlignedBench bench;
  std::vector<std::pair<std::int64_t, std::int64_t>> ends;
  for (const DirectPose& direct : bench.map.graph.direct_poses()) ends.emplace_back(direct.keyframe, direct.camera);
  // All of them see what 7 sees: the first ids of equals, then the oldest of the rest, of which 2 cannot be aligned.
  EXPECT_THAT(ends, ::testing::IsSupersetOf({std::pair<std::int64_t, std::int64_t>{0, 7}, {7, 0}, {1, 7}, {7, 1}}));
  EXPECT_EQ(ends.size(), 8U);
  for (const auto& [from, to] : ends) EXPECT_TRUE(from != 2 && to != 2);
}

TEST(DirectPoses, GoWithTheirKeyframes) {
  AlignedBench bench;
  bench.map.graph.set_parent(7, 6);
  bench.map.graph.remove_keyframe(7);
  EXPECT_TRUE(bench.map.graph.direct_poses().empty());
}

TEST(DirectPoses, CountInTheBundleWhereOneEndIsFree) {
  AlignedBench bench;
  EXPECT_EQ(bundle_problem(bench.map.graph, {7}, {0, 1}, 1.0).bundle.relative_poses.size(), 4U);
  EXPECT_EQ(bundle_problem(bench.map.graph, {6}, {0, 7}, 1.0).bundle.relative_poses.size(), 0U);
}

TEST(DirectPoses, MoveAKeyframeThatFeaturesMisplace) {
  AlignedBench bench;
  MapKeyframe& last = bench.map.graph.keyframe(7);
  for (std::size_t i = 0; i < last.landmarks.size(); ++i)
    if (last.landmarks[i] >= 0 && i % 20 != 0) bench.map.graph.remove_observation(7, last.landmarks[i]);
  last.camera_from_world = SE3(SO3(), {0.02, 0.0, 0.0}) * last.camera_from_world;
  BundleProblem problem = bundle_problem(bench.map.graph, {7}, {0, 1, 3, 4}, 50.0);
  adjust_bundle_problem(problem, 10, {}, nullptr);
  EXPECT_LT((problem.bundle.camera_from_world.front() * mapping_pose(7).inverse()).log().norm(), 1e-4);
}

}  // namespace
}  // namespace rastro
