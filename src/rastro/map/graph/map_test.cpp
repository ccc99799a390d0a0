// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/map.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/map/landmarks/landmark_map_testing.h"

namespace rastro {
namespace {

constexpr std::int64_t last_number = (std::int64_t{1} << 36) - 1;

TEST(KeyframeId, HoldsItsPartsUpToTheirLimits) {
  for (const int robot : {0, 1, 2047})
    for (const int session : {0, 1, 65'535})
      for (const std::int64_t number : {std::int64_t{0}, std::int64_t{1}, last_number}) {
        const KeyframeOrigin origin{robot, session, number};
        EXPECT_EQ(origin_of(keyframe_id(origin)), origin) << robot << ' ' << session << ' ' << number;
      }
  EXPECT_EQ(keyframe_id({0, 0, 5}), 5) << "of the first robot's first session: its number";
  EXPECT_EQ(keyframe_id({2047, 65'535, last_number}), std::numeric_limits<KeyframeId>::max());
}

TEST(KeyframeId, OrdersByRobotSessionAndNumber) {
  EXPECT_LT(keyframe_id({0, 0, last_number}), keyframe_id({0, 1, 0}));
  EXPECT_LT(keyframe_id({0, 65'535, last_number}), keyframe_id({1, 0, 0}));
  EXPECT_LT(keyframe_id({1, 7, 8}), keyframe_id({1, 7, 9}));
}

TEST(Map, FindsKeyframesByIdAmongGaps) {
  const Map map = make_landmark_test_map();
  std::size_t found = 0;
  for (KeyframeId id = -2; id < 30; ++id) {
    std::optional<std::size_t> expected;
    for (std::size_t k = 0; k < map.keyframes.size(); ++k)
      if (map.keyframes[k].id == id) expected = k;
    EXPECT_EQ(map.index_of(id), expected) << id;
    EXPECT_EQ(map.find(id), expected ? &map.keyframes[*expected] : nullptr) << id;
    found += expected ? 1 : 0;
  }
  EXPECT_EQ(found, map.keyframes.size());
  EXPECT_FALSE(map.index_of(std::numeric_limits<KeyframeId>::max()));
  EXPECT_FALSE(Map().index_of(0));
}

/// Three keyframes a second apart, 1 m apart along x, the last one in submap 1; the first is at `first_x`.
Map three_keyframes(double first_x = 0.0) {
  Map map;
  for (int k = 0; k < 3; ++k)
    map.keyframes.push_back({10 * k, k, 1000 * k, 0, SE3(SO3(), {first_x + k, 0.0, 0.0}), k / 2, no_keyframe, 1.0});
  return map;
}

TEST(Map, TrajectoryFollowsAKeyframeThatIsMoved) {
  Map map = three_keyframes();
  const SE3 beside(SO3(), {0.0, 0.5, 0.0});
  map.frames = {{1500, 10, beside}, {500, 0, beside}, {0, 0, SE3()}, {500, 0, SE3()}, {2500, 20, beside}};
  Trajectory trajectory = trajectory_of(map);
  ASSERT_EQ(trajectory.size(), 3U) << "of submap 0, each stamp once";
  EXPECT_EQ(trajectory[0].stamp, 0);
  EXPECT_EQ(trajectory[1].stamp, 500);
  EXPECT_EQ(trajectory[1].world_from_body.translation(), Eigen::Vector3d(0.0, 0.5, 0.0))
      << "the first one of its stamp";
  EXPECT_EQ(trajectory[2].world_from_body.translation(), Eigen::Vector3d(1.0, 0.5, 0.0));
  map.keyframes[1].world_from_camera = SE3(SO3(), {7.0, 8.0, 9.0});
  trajectory = trajectory_of(map);
  EXPECT_EQ(trajectory[1].world_from_body.translation(), Eigen::Vector3d(0.0, 0.5, 0.0));
  EXPECT_EQ(trajectory[2].world_from_body.translation(), Eigen::Vector3d(7.0, 8.5, 9.0));
  ASSERT_EQ(trajectory_of(map, 1).size(), 1U);
  EXPECT_EQ(trajectory_of(map, 1)[0].world_from_body.translation(), Eigen::Vector3d(2.0, 0.5, 0.0));
  EXPECT_TRUE(trajectory_of(map, 2).empty());
}

TEST(Map, KeyframeTrajectoryIsByStamp) {
  Map map = three_keyframes();
  map.keyframes[0].stamp = 1001;
  const Trajectory trajectory = keyframe_trajectory(map);
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory[0].stamp, 1000);
  EXPECT_EQ(trajectory[1].stamp, 1001);
  EXPECT_EQ(keyframe_trajectory(map, 1).size(), 1U);
}

TEST(Map, AFrameIsRelativeToTheLastKeyframeBeforeIt) {
  const Map map = three_keyframes(5.0);
  const SE3 pose(SO3::exp({0.1, -0.2, 0.3}), {9.0, 8.0, 7.0});
  const std::pair<TimeNs, KeyframeId> expected[] = {{-5, 0}, {0, 0}, {999, 0}, {1000, 10}, {1'000'000, 10}};
  for (const auto& [stamp, keyframe] : expected) {
    const auto frame = frame_in(map, {stamp, pose});
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->stamp, stamp);
    EXPECT_EQ(frame->keyframe, keyframe) << stamp;
    const SE3 again = map.find(keyframe)->world_from_camera * frame->keyframe_from_camera;
    EXPECT_LT((again.inverse() * pose).log().norm(), 1e-14);
  }
  EXPECT_EQ(frame_in(map, {0, pose}, 1)->keyframe, 20) << "the first one of the submap where all are later";
  EXPECT_FALSE(frame_in(map, {0, pose}, 2));
  EXPECT_FALSE(frame_in(Map(), {0, pose}));
}

TEST(Map, WithoutSessionsAndCamerasItsUnitIsArbitraryAndItsCameraAnError) {
  EXPECT_FALSE(scale_of(Map()).metric);
  EXPECT_EQ(scale_of(Map()).origin, "arbitrary");
  EXPECT_THROW(camera_of(Map(), "here"), Error);
  const Map map = make_landmark_test_map();
  EXPECT_EQ(&camera_of(map, "here"), &map.cameras.front());
  EXPECT_EQ(&scale_of(map), &map.sessions.front().scale);
}

TEST(Map, AMapWithoutCamerasHasPosesOfTheBody) {
  Map map = three_keyframes();
  EXPECT_EQ(contradiction_in(map), "");
  map.keyframes[1].camera = 1;
  EXPECT_EQ(contradiction_in(map), "has a keyframe of a camera that is not there");
}

TEST(Names, AreThoseOfEveryKind) {
  EXPECT_STREQ(name_of(ConstraintKind::odometry), "odometry");
  EXPECT_STREQ(name_of(ConstraintKind::inter_robot), "inter_robot");
  EXPECT_STREQ(name_of(CameraKind::mono), "one camera");
  EXPECT_STREQ(name_of(CameraKind::none), "no camera");
}

TEST(LayerSet, HasEachLayerOnceByItsName) {
  LayerSet layers;
  EXPECT_FALSE(layers.get<LandmarkLayer>());
  const auto landmarks = std::make_shared<const LandmarkLayer>();
  layers.put<LandmarkLayer>(landmarks);
  layers.put<LandmarkLayer>(std::make_shared<const LandmarkLayer>());
  layers.put<LandmarkLayer>(landmarks);
  EXPECT_EQ(layers.get<LandmarkLayer>(), landmarks);
  EXPECT_EQ(layers.find("landmarks"), landmarks);
  EXPECT_EQ(layers.all().size(), 1U);
  layers.put<LandmarkLayer>(nullptr);
  EXPECT_TRUE(layers.all().empty());
}

}  // namespace
}  // namespace rastro
