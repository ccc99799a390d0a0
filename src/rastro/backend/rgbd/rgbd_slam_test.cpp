// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/rgbd_slam.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/base/error.h"
#include "rastro/base/task_pool.h"

namespace rastro {
namespace {

using testing::looking;
using testing::pose_near;
using testing::room_frame;

/// A view; nullopt: darkness.
using Views = std::vector<std::optional<SE3>>;

/// The results of a run over these views, frame by frame and at the end.
struct Driven {
  std::vector<SlamUpdate> updates;
  std::vector<SlamEvent> events;
  std::map<TimeNs, SE3> trajectory;
  std::shared_ptr<const Map> snapshot;

  int count(const std::string& kind) const {
    return static_cast<int>(
        std::count_if(events.begin(), events.end(), [&](const SlamEvent& event) { return event.kind == kind; }));
  }
};

Frame frame_of(const std::optional<SE3>& view, std::int64_t index) {
  if (view) return room_frame(*view, index);
  Frame frame = room_frame(looking({0.0, 0.0, 1.2}, 0.0), index);
  for (int y = 0; y < 240; ++y) std::fill_n(frame.image.row(y), 320, std::uint8_t{0});
  for (int y = 0; y < 240; ++y) std::fill_n(frame.depth.row(y), 320, 0.0F);
  frame.color.rgb = {};
  return frame;
}

Driven run(const Views& views, const RgbdSlamOptions& options, const SlamContext& context = {}) {
  RgbdSlam slam("rgbd", options, test_room::camera(), context);
  Driven result;
  for (std::size_t k = 0; k < views.size(); ++k) {
    result.updates.push_back(slam.process(frame_of(views[k], static_cast<std::int64_t>(k))));
    const auto& events = result.updates.back().events;
    result.events.insert(result.events.end(), events.begin(), events.end());
  }
  const auto last = slam.finish();
  result.events.insert(result.events.end(), last.begin(), last.end());
  for (const StampedPose& pose : slam.trajectory()) result.trajectory[pose.stamp] = pose.world_from_body;
  result.snapshot = slam.snapshot();
  return result;
}

/// Radians per frame in yaw, with a motion to the side.
Views pan(double yaw, double per_frame, int frames) {
  Views views;
  for (int k = 0; k < frames; ++k) views.push_back(looking({-0.5, -0.2 + 0.01 * k, 1.2}, yaw + per_frame * k, -0.3));
  return views;
}

Views concatenated(std::initializer_list<Views> parts) {
  Views all;
  for (const Views& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// The world is the first camera.
SE3 in_world(const Views& views, std::size_t k) { return views[0]->inverse() * *views[k]; }

void expect_near_ground_truth(const Driven& done, const Views& views, double meters, double radians) {
  for (std::size_t k = 0; k < views.size(); ++k) {
    const auto found = done.trajectory.find(done.updates[k].stamp);
    if (!views[k] || found == done.trajectory.end()) continue;
    EXPECT_THAT(found->second, pose_near(in_world(views, k), meters, radians)) << k;
  }
}

RgbdSlamOptions quick() {
  RgbdSlamOptions options;
  options.backend_delay_frames = 3;
  options.keyframe_frames = 8;
  options.lost_frames = 3;
  options.relocalize_every = 1;
  options.max_acceleration = 0.0;  // poses of these small noisy images jitter
  return options;
}

TEST(RgbdSlam, TracksAPanAndItsMapHasTheKeyframes) {
  const Views views = pan(-0.3, 0.02, 30);
  const Driven done = run(views, quick());
  ASSERT_EQ(done.trajectory.size(), views.size());
  expect_near_ground_truth(done, views, 0.03, 0.012);
  EXPECT_EQ(done.updates[0].world_from_body.matrix(), SE3().matrix()) << "the world is the first camera";
  EXPECT_GE(done.count("keyframe"), 3);
  ASSERT_EQ(done.snapshot->keyframes.size(), static_cast<std::size_t>(done.count("keyframe")));
  EXPECT_EQ(done.snapshot->layer<FeatureLayer>()->of.size(), done.snapshot->keyframes.size());
  EXPECT_EQ(done.snapshot->layer<ImageLayer>()->keyframes.size(), done.snapshot->keyframes.size());
  for (const Keyframe& keyframe : done.snapshot->keyframes)
    EXPECT_THAT(keyframe.world_from_camera, pose_near(done.trajectory.at(keyframe.stamp), 1e-9, 1e-9)) << keyframe.id;
  for (std::size_t k = 1; k < views.size(); ++k) {
    EXPECT_EQ(done.updates[k].state, SlamState::tracking) << k;
    ASSERT_TRUE(done.updates[k].covariance);
    EXPECT_GT(done.updates[k].covariance->diagonal().minCoeff(), 0.0) << k;
  }
}

TEST(RgbdSlam, AStepThatHardlyAnyCameraMakesIsWeak) {
  Views views = pan(-0.3, 0.0, 10);
  for (std::size_t k = 5; k < views.size(); ++k)
    views[k] = *views[k] * SE3(SO3(), {0.04, 0.0, 0.0});  // 4 cm in a frame
  RgbdSlamOptions options = quick();
  options.max_acceleration = 20.0;
  const Driven done = run(views, options);
  EXPECT_EQ(done.updates[3].state, SlamState::tracking);
  EXPECT_EQ(done.updates[5].state, SlamState::weak);
  EXPECT_EQ(done.updates[5].reason, SlamReason::implausible_motion);
  EXPECT_NE(done.updates[5].detail.find("at most 20 is plausible"), std::string::npos) << done.updates[5].detail;
}

TEST(RgbdSlam, AnOdometryEdgeHasAMinimumSigma) {
  RgbdSlamOptions options = quick();
  options.edge_sigma_m = 0.02;
  options.edge_sigma_rad = 0.01;
  const Driven done = run(pan(-0.2, 0.02, 14), options);
  int odometry = 0;
  for (const Constraint& edge : done.snapshot->constraints) {
    if (edge.kind != ConstraintKind::odometry) continue;
    ++odometry;
    const Matrix6d covariance = edge.information.inverse();
    for (int i = 0; i < 6; ++i) EXPECT_GT(covariance(i, i), i < 3 ? 0.0004 : 0.0001);
  }
  EXPECT_EQ(odometry, static_cast<int>(done.snapshot->keyframes.size()) - 1);
}

/// Mapping results are handed over a fixed number of frames later, neither sooner nor later.
TEST(RgbdSlam, AKeyframeIsKnownAfterTheDelay) {
  RgbdSlamOptions options = quick();
  options.backend_delay_frames = 4;
  RgbdSlam slam("rgbd", options, test_room::camera(), {});
  const Views views = pan(0.0, 0.005, 6);
  for (std::size_t k = 0; k < views.size(); ++k) {
    slam.process(room_frame(*views[k], static_cast<std::int64_t>(k)));
    EXPECT_EQ(slam.snapshot()->keyframes.size(), k < 4 ? 0U : 1U) << k;
  }
}

TEST(RgbdSlam, InALiveRunAKeyframeIsKnownAsSoonAsItIsReady) {
  RgbdSlamOptions options = quick();
  options.backend_delay_frames = 4;
  SlamContext context;
  context.live = true;
  RgbdSlam slam("rgbd", options, test_room::camera(), context);
  const Views views = pan(0.0, 0.005, 2);
  for (std::size_t k = 0; k < views.size(); ++k) {
    slam.process(room_frame(*views[k], static_cast<std::int64_t>(k)));
    EXPECT_EQ(slam.snapshot()->keyframes.size(), k) << k;
  }
}

TEST(RgbdSlam, TheCovarianceIsConsistentWithTheError) {
  const Views views = pan(-0.3, 0.02, 30);
  const Driven done = run(views, quick());
  for (std::size_t k = 5; k < views.size(); ++k) {
    const SE3 ground_truth = in_world(views, k), said = done.updates[k].world_from_body;
    const Eigen::Vector3d error = ground_truth.translation() - said.translation();
    const Eigen::Matrix3d covariance = done.updates[k].covariance->topLeftCorner<3, 3>();
    EXPECT_LT(error.dot(covariance.ldlt().solve(error)), 25.0) << k << ": beyond 5 sigma";
  }
}

TEST(RgbdSlam, IsLostInTheDarkAndRelocalizedInTheMap) {
  const Views before = pan(-0.2, 0.02, 15), dark(4), after = pan(0.2, 0.01, 8);
  const Views views = concatenated({before, dark, after});
  const Driven done = run(views, quick());
  for (std::size_t k = 15; k < 19; ++k) {
    EXPECT_EQ(done.updates[k].state, SlamState::lost) << k;
    EXPECT_EQ(done.trajectory.count(done.updates[k].stamp), 0U) << "no pose, none in the trajectory";
  }
  EXPECT_EQ(done.updates[19].state, SlamState::relocalized);
  EXPECT_THAT(done.updates[19].world_from_body, pose_near(in_world(views, 19), 0.03, 0.015));
  EXPECT_EQ(done.count("relocalized") + done.count("submap"), done.count("relocalized")) << "no new submap";
  EXPECT_EQ(done.trajectory.size(), views.size() - dark.size());
  expect_near_ground_truth(done, views, 0.04, 0.02);
}

/// Moved to another wall in the dark and from there, in light, back to the first: the two submaps are merged, in the
/// frame of the first.
TEST(RgbdSlam, ASubmapBegunElsewhereIsMergedWithTheFirstWhereTheyOverlap) {
  const Views first = pan(0.0, 0.01, 14), dark(3), back = pan(2.4, -0.08, 32), on = pan(-0.15, 0.01, 8);
  const Views views = concatenated({first, dark, back, on});
  const Driven done = run(views, quick());
  EXPECT_GE(done.count("submap"), 1);
  ASSERT_GE(done.count("joined"), 1);
  const bool disconnected = std::any_of(done.updates.begin(), done.updates.end(), [](const SlamUpdate& update) {
    return update.state == SlamState::weak && update.reason == SlamReason::apart;
  });
  EXPECT_TRUE(disconnected) << "until they meet, a pose is a guess and says so";
  for (const Keyframe& keyframe : done.snapshot->keyframes) EXPECT_EQ(keyframe.submap, 0);
  EXPECT_GT(done.trajectory.size(), views.size() - 10) << "all but the dark and the first frames after it";
  expect_near_ground_truth(done, views, 0.12, 0.05);
  EXPECT_NE(done.updates.back().reason, SlamReason::apart) << "it is known to the tracker";
  EXPECT_THAT(done.updates.back().world_from_body, pose_near(in_world(views, views.size() - 1), 0.12, 0.05));
}

TEST(RgbdSlam, FramesAreLocalizedInAGivenMapWhichStays) {
  SlamContext context;
  context.map = std::make_shared<const Map>(make_test_map(6));
  const SE3 beside(SO3::exp({0.02, 0.06, 0.0}), {0.12, 0.05, 0.0});
  const SE3 start = context.map->keyframes[2].world_from_camera * beside;
  Views views;
  for (int k = 0; k < 12; ++k) views.emplace_back(start * SE3(SO3::exp({0.0, 0.006 * k, 0.0}), {0.01 * k, 0.0, 0.0}));
  RgbdSlamOptions options = quick();
  options.relocalize_last = 6;
  const Driven done = run(views, options, context);
  for (const std::size_t k : {0U, 1U}) EXPECT_EQ(done.updates[k].reason, SlamReason::unconfirmed) << k;
  EXPECT_EQ(done.updates[2].state, SlamState::relocalized);
  for (std::size_t k = 2; k < views.size(); ++k)
    EXPECT_THAT(done.updates[k].world_from_body, pose_near(*views[k], 0.04, 0.02)) << "in the frame of the map";
  EXPECT_EQ(done.snapshot->keyframes.size(), 6U);
  EXPECT_EQ(done.trajectory.size(), views.size());
}

TEST(RgbdSlam, AMapOfAnotherCameraIsRefused) {
  Map map = make_test_map(2);
  SlamContext context;
  const auto refused = [&](const Camera& camera) {
    map.cameras.at(0).intrinsics = camera;
    context.map = std::make_shared<const Map>(map);
    try {
      RgbdSlam slam("rgbd", {}, test_room::camera(), context);
    } catch (const Error&) {
      return true;
    }
    return false;
  };
  EXPECT_FALSE(refused(test_room::camera()));
  Camera camera = test_room::camera();
  camera.fx *= 1.0005;
  EXPECT_FALSE(refused(camera)) << "calibrated once more";
  EXPECT_TRUE(refused(test_room::camera().scaled(2.0)));
  camera = test_room::camera();
  camera.fx = camera.fy = 300.0;
  EXPECT_TRUE(refused(camera));
  camera = test_room::camera();
  camera.cx += 20.0;
  EXPECT_TRUE(refused(camera));
}

TEST(RgbdSlam, OptionsOutOfRangeAreRefused) {
  RgbdSlamOptions options;
  options.graph_window = 1;
  EXPECT_THROW(RgbdSlam("rgbd", options, test_room::camera(), {}), Error);
  options = {};
  options.loops = "hopeful";
  EXPECT_THROW(RgbdSlam("rgbd", options, test_room::camera(), {}), Error);
}

TEST(RgbdSlam, MappingBesideTrackingGivesTheSameResult) {
  const Views views = concatenated({pan(-0.2, 0.02, 12), Views(2), pan(0.0, 0.01, 6)});
  const Driven alone = run(views, quick());
  TaskPool pool(3);
  SlamContext context;
  context.pool = &pool;
  context.pipelined = true;
  const Driven beside = run(views, quick(), context);
  ASSERT_EQ(alone.trajectory.size(), beside.trajectory.size());
  for (const auto& [stamp, pose] : alone.trajectory) EXPECT_EQ(pose.matrix(), beside.trajectory.at(stamp).matrix());
  for (std::size_t k = 0; k < views.size(); ++k) {
    EXPECT_EQ(alone.updates[k].world_from_body.matrix(), beside.updates[k].world_from_body.matrix()) << k;
    EXPECT_EQ(alone.updates[k].events.size(), beside.updates[k].events.size()) << k;
  }
}

TEST(RgbdSlam, WhileLostTheMapIsSearchedInTheFirstFrameAndThenInEveryNth) {
  const Views views = pan(-0.2, 0.02, 12);
  SlamContext context;
  context.map = run(views, quick()).snapshot;
  for (const int every : {1, 2, 3}) {
    RgbdSlamOptions options = quick();
    options.relocalize_every = every;
    for (int elsewhere = 0; elsewhere <= 4; ++elsewhere) {
      RgbdSlam slam("rgbd", options, test_room::camera(), context);
      std::int64_t index = 0;
      // The opposite wall, which the map does not have.
      for (int k = 0; k < elsewhere; ++k)
        EXPECT_EQ(slam.process(frame_of(looking({-0.5, 0.01 * k, 1.2}, M_PI), index++)).used, 0);
      const bool found = slam.process(frame_of(views[0], index)).reason == SlamReason::unconfirmed;
      EXPECT_EQ(found, elsewhere % every == 0) << "after " << elsewhere << " frames, every " << every;
    }
  }
}

/// The right surfaces with another picture on them, after the camera saw the opposite wall, which the map does not
/// have.
TEST(RgbdSlam, AfterALongLossSurfacesAloneAreNotBelieved) {
  const Views views = pan(-0.2, 0.02, 12);
  SlamContext context;
  context.map = run(views, quick()).snapshot;
  for (const int lost : {3, 9}) {
    RgbdSlam slam("rgbd", quick(), test_room::camera(), context);
    std::int64_t index = 0;
    for (const std::size_t k : {0, 1, 2, 3, 4, 5}) slam.process(frame_of(views[k], index++));
    for (int k = 0; k < lost; ++k)
      EXPECT_EQ(slam.process(frame_of(looking({-0.5, 0.01 * k, 1.2}, M_PI), index++)).state, SlamState::lost);
    Frame mirrored = frame_of(views[5], index++);
    for (int y = 0; y < mirrored.image.height(); ++y)
      for (int left = 0, right = mirrored.image.width() - 1; left < right; ++left, --right)
        std::swap(mirrored.image.at(left, y), mirrored.image.at(right, y));
    const SlamUpdate update = slam.process(mirrored);
    EXPECT_EQ(update.state, lost == 3 ? SlamState::relocalized : SlamState::lost) << update.detail;
  }
}

/// The follower does not know the other end of the map; only relocalization does.
TEST(RgbdSlam, RightAfterALossEveryFrameIsRelocalized) {
  const Views views = pan(-0.2, 0.06, 24);
  SlamContext context;
  context.map = run(views, quick()).snapshot;
  RgbdSlamOptions options = quick();
  options.relocalize_every = 1000;
  for (const int elsewhere : {1, 4, 5}) {
    RgbdSlam slam("rgbd", options, test_room::camera(), context);
    std::int64_t index = 0;
    for (int k = 0; k < 6; ++k) slam.process(frame_of(views[static_cast<std::size_t>(k)], index++));
    for (int k = 0; k < elsewhere; ++k) {
      const Frame unknown = testing::unknown_frame(static_cast<std::uint64_t>(k), 2.0F);
      Frame frame = room_frame(*views[0], index++);
      frame.image = unknown.image;
      frame.depth = unknown.depth;
      EXPECT_EQ(slam.process(frame).state, SlamState::lost);
    }
    const bool found = slam.process(frame_of(views.back(), index)).reason == SlamReason::unconfirmed;
    EXPECT_EQ(found, elsewhere < 5) << "after " << elsewhere << " lost frames";
  }
}

/// A frame that is found elsewhere in the map, or not at all, begins the count anew.
TEST(RgbdSlam, ARelocalizationIsBelievedOnceEnoughFramesAgree) {
  const Views views = pan(-0.2, 0.04, 12);
  SlamContext context;
  context.map = run(views, quick()).snapshot;
  const auto opposite = looking({-0.5, 0.0, 1.2}, M_PI);
  for (const auto& [between, agrees] : {std::pair{*views[1], true}, {*views[10], false}, {opposite, false}}) {
    RgbdSlamOptions options = quick();
    options.relocalize_frames = 3;
    RgbdSlam slam("rgbd", options, test_room::camera(), context);
    std::int64_t index = 0;
    for (const SE3& view : {*views[0], between})
      EXPECT_EQ(slam.process(frame_of(view, index++)).state, SlamState::lost);
    EXPECT_TRUE(slam.trajectory().empty()) << "no pose is given before";
    const SlamUpdate third = slam.process(frame_of(views[1], index++));
    EXPECT_EQ(third.state == SlamState::relocalized, agrees) << third.detail;
    EXPECT_EQ(slam.trajectory().size(), agrees ? 3U : 0U);
  }
}

TEST(RgbdSlam, AMapWithoutDepthsOfItsFeaturesIsRefused) {
  Map map = make_test_map(2);
  SlamContext context;
  context.map = std::make_shared<const Map>(map);
  EXPECT_NO_THROW(RgbdSlam("rgbd", {}, test_room::camera(), context));
  auto layer = std::make_shared<FeatureLayer>(*map.layer<FeatureLayer>());
  auto bare = std::make_shared<ImageFeatures>(*layer->of.begin()->second);
  bare->depths.pop_back();
  layer->of.begin()->second = std::move(bare);
  map.layers.put<FeatureLayer>(std::move(layer));
  context.map = std::make_shared<const Map>(map);
  EXPECT_THROW(RgbdSlam("rgbd", {}, test_room::camera(), context), Error);
}

}  // namespace
}  // namespace rastro
