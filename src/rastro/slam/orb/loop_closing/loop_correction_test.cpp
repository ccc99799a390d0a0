// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/loop_closing/loop_correction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::PointWorld;
using testing::pose_near;

/// Camera k of a row that turns and rises.
SE3 in_row(int k) { return SE3(SO3::exp({0.01 * k, -0.02 * k, 0.03 * k}), {-0.2 * k, 0.05 * k, 0.02 * k}); }

VerifiedLoop loop_of(const MapGraph& graph, std::int64_t keyframe, std::int64_t matched) {
  VerifiedLoop loop;
  loop.keyframe = keyframe;
  loop.matched = matched;
  const SE3 relative = graph.camera_from_world(keyframe) * graph.camera_from_world(matched).inverse();
  loop.keyframe_from_matched = Sim3(relative);
  loop.inliers = 17;
  return loop;
}

/// Keyframes 0 to 5, each of which shares landmarks with the next, and 0 to 2 many with each other; an earlier loop
/// leads from 4 to 0.
struct Row {
  explicit Row(CameraKind sensor) : map(world, sensor, sensor == CameraKind::mono ? 0.0 : 0.1) {
    map.add(0, in_row(0), {.from = 0, .to = 200});
    map.add(1, in_row(1), {.from = 0, .to = 200});
    map.add(2, in_row(2), {.from = 20, .to = 220});
    map.add(3, in_row(3), {.from = 210, .to = 260});
    map.add(4, in_row(4), {.from = 230, .to = 300});
    map.add(5, in_row(5), {.from = 260, .to = 300});
    graph.constraints().push_back(known(4, 0));
  }
  Constraint known(std::int64_t from, std::int64_t to) const {
    Constraint constraint;
    constraint.from = from;
    constraint.to = to;
    constraint.from_from_to = Sim3(graph.camera_from_world(from) * graph.camera_from_world(to).inverse());
    constraint.kind = ConstraintKind::loop;
    return constraint;
  }

  PointWorld world{300, 5};
  ExactMap map;
  MapGraph& graph = map.graph;
};

TEST(LoopCorrection, ALoopThatFitsTheMapMovesNothing) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    Row row(sensor);
    OrbSlamOptions options;
    options.essential_landmarks = 30;
    const LoopResult result = correct_loop(row.graph, options, loop_of(row.graph, 5, 1));
    EXPECT_FALSE(result.merged);
    EXPECT_EQ(result.keyframe, 5);
    EXPECT_EQ(result.matched, 1);
    EXPECT_EQ(result.inliers, 17);
    EXPECT_EQ(result.landmarks, 0);
    EXPECT_NEAR(result.moved, 0.0, 1e-9);
    EXPECT_EQ(result.scale, 1.0);
    for (int k = 0; k < 6; ++k) {
      EXPECT_THAT(row.graph.camera_from_world(k), pose_near(in_row(k), 1e-9, 1e-9)) << k;
      EXPECT_NEAR(row.graph.unit(k), 1.0, 1e-9);
    }
    for (std::size_t point = 0; point < 300; ++point) {
      const std::int64_t landmark = row.map.landmark_of[point];
      if (landmark < 0) continue;
      EXPECT_LT((row.graph.landmark(landmark).position - row.world.points[point]).norm(), 1e-7) << point;
    }
    ASSERT_EQ(row.graph.constraints().size(), 2U);
    const Constraint& added = row.graph.constraints().back();
    EXPECT_EQ(added.from, 5);
    EXPECT_EQ(added.to, 1);
    EXPECT_EQ(added.kind, ConstraintKind::loop);
    EXPECT_EQ(added.inliers, 17);
    EXPECT_THAT(added.rigid(), pose_near(in_row(5) * in_row(1).inverse(), 1e-9, 1e-9));
  }
}

/// A loop that is 0.3 m off moves the end most and the root not at all, and all landmarks with their keyframes.
TEST(LoopCorrection, TheErrorIsSpreadAndLandmarksStayWhereTheirFirstKeyframeSeesThem) {
  Row row(CameraKind::depth);
  VerifiedLoop loop = loop_of(row.graph, 5, 1);
  const SE3 off(loop.keyframe_from_matched.rotation(),
                loop.keyframe_from_matched.translation() + Eigen::Vector3d(0.0, 0.3, 0.0));
  loop.keyframe_from_matched = Sim3(off);
  const LoopResult result = correct_loop(row.graph, OrbSlamOptions(), loop);
  std::vector<double> moved;
  for (int k = 0; k < 6; ++k)
    moved.push_back(
        (row.graph.camera_from_world(k).inverse().translation() - in_row(k).inverse().translation()).norm());
  EXPECT_EQ(result.moved, moved[5]);
  EXPECT_EQ(std::max_element(moved.begin(), moved.end()) - moved.begin(), 5);
  EXPECT_GT(moved[5], 0.05);
  EXPECT_LT(moved[0], 1e-9);
  for (const std::int64_t id : row.graph.landmark_ids()) {
    const MapLandmark landmark = row.graph.landmark(id);
    const std::int64_t first = landmark.first_keyframe;
    const Eigen::Vector3d now = row.graph.camera_from_world(first) * landmark.position;
    double error = 1e9;
    for (const Eigen::Vector3d& point : row.world.points)
      error = std::min(error, (in_row(static_cast<int>(first)) * point - now).norm());
    EXPECT_TRUE(error < 1e-9 || first >= 3) << id << ": " << error;
    row.graph.describe(id);
    EXPECT_EQ(landmark.direction, row.graph.landmark(id).direction) << "described again where it is";
  }
}

/// The camera is back at the root, and recognizes the other end of the row.
TEST(LoopCorrection, TheRootStaysWhereItIsAlsoWhereItIsAmongThoseThatMove) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    Row row(sensor);
    OrbSlamOptions options;
    options.loop_search_px = 0.001;  // nothing is fused
    ASSERT_GE(row.graph.shared(1, 0), options.covisible_landmarks);
    VerifiedLoop loop = loop_of(row.graph, 1, 5);
    const double scale = sensor == CameraKind::mono ? 1.1 : 1.0;
    loop.keyframe_from_matched =
        Sim3(scale, loop.keyframe_from_matched.rotation(),
             scale * loop.keyframe_from_matched.translation() + Eigen::Vector3d(0.0, 0.3, 0.0));
    correct_loop(row.graph, options, loop);
    EXPECT_THAT(row.graph.camera_from_world(0), pose_near(in_row(0), 1e-12, 1e-12));
    EXPECT_NEAR(row.graph.unit(0), 1.0, 1e-12);
    const Eigen::Vector3d end = row.graph.camera_from_world(5).inverse().translation();
    EXPECT_GT((end - in_row(5).inverse().translation()).norm(), 0.05) << "the others are corrected";
    if (sensor == CameraKind::mono) {
      EXPECT_GT(std::abs(row.graph.unit(5) - 1.0), 0.01);
    }
    // Landmarks go with their keyframes.
    const std::int64_t first = row.map.landmark_of[0];
    ASSERT_EQ(row.graph.landmark(first).first_keyframe, 0);
    const Eigen::Vector3d in_second = row.graph.camera_from_world(1) * row.graph.landmark(first).position;
    EXPECT_LT((in_second - row.graph.unit(1) * (in_row(1) * row.world.points[0])).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace rastro
