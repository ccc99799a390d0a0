// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/frame_trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::Observed;
using testing::PointWorld;
using testing::pose_near;

constexpr TimeNs tenth = 100000000;

SE3 pose_at(double meters) { return SE3(SO3::exp({0.0, 0.1 * meters, 0.02}), {meters, 0.1 * meters, 0.0}); }

/// As tracking hands it over: at `world_from_camera`, relative to a keyframe of the graph.
TrackedFrame frame_at(const MapGraph& graph, std::int64_t index, std::int64_t keyframe, const SE3& world_from_camera) {
  TrackedFrame frame;
  frame.index = index;
  frame.stamp = tenth * index;
  frame.keyframe = keyframe;
  frame.camera_from_keyframe = (graph.camera_from_world(keyframe) * world_from_camera).inverse();
  frame.unit = graph.unit(keyframe);
  return frame;
}

/// A map of two keyframes and a trajectory past them.
struct PathBench {
  explicit PathBench(CameraKind sensor = CameraKind::mono)
      : map(world, sensor, sensor == CameraKind::mono ? 0.0 : 0.1) {
    map.add(0, pose_at(0.0).inverse());
    map.add(1, pose_at(1.0).inverse());
  }
  /// A frame with pose error `error`, but with the observations from `world_from_camera`.
  TrackedFrame seeing(std::int64_t index, std::int64_t keyframe, const SE3& world_from_camera, const SE3& error) {
    const Observed observed =
        world.observe(100 + index, world_from_camera.inverse(), {.baseline = map.graph.baseline()});
    TrackedFrame frame = frame_at(map.graph, index, keyframe, world_from_camera * error);
    auto measured = std::make_shared<FrameMeasurements>();
    for (const TrackedPoint& point : map.tracked(observed)) {
      const Eigen::Vector2d ray = observed.frame->ray(point.feature);
      measured->seen.push_back({point.landmark, ray.cast<float>(),
                                static_cast<float>(observed.frame->right_ray(point.feature)),
                                static_cast<float>(map.graph.sigma(*observed.frame, point.feature))});
    }
    frame.measured = std::move(measured);
    return frame;
  }

  PointWorld world{120, 3};
  ExactMap map;
  FrameTrajectory recorded;
};

/// With the landmarks of the smallest numbers alone.
std::shared_ptr<const FrameMeasurements> first_of(const TrackedFrame& frame, std::size_t count) {
  auto measured = std::make_shared<FrameMeasurements>(*frame.measured);
  std::sort(measured->seen.begin(), measured->seen.end(),
            [](const auto& a, const auto& b) { return a.landmark < b.landmark; });
  measured->seen.resize(count);
  return measured;
}

std::shared_ptr<const FrameMeasurements> with(const TrackedFrame& frame, const DirectObservation& direct) {
  auto measured = std::make_shared<FrameMeasurements>(*frame.measured);
  measured->direct = std::make_shared<const DirectObservation>(direct);
  return measured;
}

/// A frame of which only the keyframe matters.
TrackedFrame beside(std::int64_t index, std::int64_t keyframe) {
  TrackedFrame frame;
  frame.index = index;
  frame.stamp = tenth * index;
  frame.keyframe = keyframe;
  return frame;
}

const SE3 some_error(SO3::exp({0.02, -0.01, 0.03}), {0.05, -0.04, 0.06});

TEST(FrameTrajectory, IsInTheOrderOfTheRecordingHoweverFramesCome) {
  PathBench bench;
  for (const int index : {3, 1, 4, 2})
    bench.recorded.add(frame_at(bench.map.graph, index, index % 2, pose_at(0.2 * index)));
  const Trajectory poses = bench.recorded.trajectory(bench.map.graph, 0);
  ASSERT_EQ(poses.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(bench.recorded.frames()[static_cast<std::size_t>(i)].index, i + 1);
    EXPECT_EQ(poses[static_cast<std::size_t>(i)].stamp, tenth * (i + 1));
    EXPECT_THAT(poses[static_cast<std::size_t>(i)].world_from_body, pose_near(pose_at(0.2 * (i + 1)), 1e-9, 1e-9));
  }
}

TEST(FrameTrajectory, FramesMoveWithTheirKeyframe) {
  PathBench bench;
  bench.recorded.add(frame_at(bench.map.graph, 1, 0, pose_at(0.2)));
  bench.recorded.add(frame_at(bench.map.graph, 2, 1, pose_at(0.8)));
  const SE3 shift(SO3::exp({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0});
  bench.map.graph.keyframe(1).camera_from_world = (shift * pose_at(1.0)).inverse();
  const Trajectory poses = bench.recorded.trajectory(bench.map.graph, 0);
  EXPECT_THAT(poses[0].world_from_body, pose_near(pose_at(0.2), 1e-9, 1e-9));
  EXPECT_THAT(poses[1].world_from_body, pose_near(shift * pose_at(0.8), 1e-9, 1e-9));
}

TEST(FrameTrajectory, ScalesWithTheMap) {
  PathBench bench;
  bench.recorded.add(frame_at(bench.map.graph, 1, 1, pose_at(0.5)));
  const Sim3 grown(2.5, SO3::exp({0.3, -0.1, 0.2}), {1.0, -2.0, 0.5});
  bench.map.graph.transform(0, grown);
  // In the larger unit already.
  bench.recorded.add(frame_at(bench.map.graph, 2, 1, SE3(SO3(), {7.0, 8.0, 9.0})));
  const Trajectory poses = bench.recorded.trajectory(bench.map.graph, 0);
  const SE3 expected(grown.rotation() * pose_at(0.5).rotation(), grown * pose_at(0.5).translation());
  EXPECT_THAT(poses[0].world_from_body, pose_near(expected, 1e-9, 1e-9));
  EXPECT_THAT(poses[1].world_from_body, pose_near(SE3(SO3(), {7.0, 8.0, 9.0}), 1e-9, 1e-9));
}

TEST(FrameTrajectory, FramesOfARemovedKeyframeKeepTheirPose) {
  PathBench bench;
  bench.recorded.add(frame_at(bench.map.graph, 1, 1, pose_at(0.7)));
  bench.map.graph.remove_keyframe(1);
  const Trajectory poses = bench.recorded.trajectory(bench.map.graph, 0);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_THAT(poses[0].world_from_body, pose_near(pose_at(0.7), 1e-9, 1e-9));
}

TEST(FrameTrajectory, TheLastPoseIsRepeatedOnlyLater) {
  PathBench bench;
  EXPECT_FALSE(bench.recorded.repeat_last(1, tenth));
  bench.recorded.add(frame_at(bench.map.graph, 3, 0, pose_at(0.3)));
  EXPECT_FALSE(bench.recorded.repeat_last(3, 4 * tenth));
  EXPECT_FALSE(bench.recorded.repeat_last(4, 3 * tenth));
  EXPECT_EQ(bench.recorded.frames().size(), 1U);
  EXPECT_TRUE(bench.recorded.repeat_last(4, 3 * tenth + 1));
  const Trajectory poses = bench.recorded.trajectory(bench.map.graph, 0);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(bench.recorded.frames()[1].index, 4);
  EXPECT_EQ(poses[1].stamp, 3 * tenth + 1);
  EXPECT_THAT(poses[1].world_from_body, pose_near(pose_at(0.3), 1e-9, 1e-9));
}

TEST(FrameTrajectory, ForgettingASubmapForgetsItsFrames) {
  PathBench bench;
  bench.map.add(2, pose_at(5.0).inverse(), {}, 1);
  for (const int index : {1, 2, 3, 4, 5}) bench.recorded.add(beside(index, index % 2 == 0 ? 2 : 1));
  EXPECT_EQ(bench.recorded.trajectory(bench.map.graph, 1).size(), 2U);
  EXPECT_EQ(bench.recorded.largest_submap(bench.map.graph), 0);
  bench.recorded.forget(bench.map.graph, 0);
  ASSERT_EQ(bench.recorded.frames().size(), 2U);
  EXPECT_EQ(bench.recorded.frames()[0].index, 2);
  EXPECT_EQ(bench.recorded.frames()[1].index, 4);
  EXPECT_TRUE(bench.recorded.trajectory(bench.map.graph, 0).empty());
  EXPECT_EQ(bench.recorded.largest_submap(bench.map.graph), 1);
}

TEST(FrameTrajectory, OfSubmapsOfEqualSizeTheFirstIsTheLargest) {
  PathBench bench;
  EXPECT_EQ(bench.recorded.largest_submap(bench.map.graph), 0);
  bench.map.add(2, pose_at(5.0).inverse(), {}, 1);
  bench.recorded.add(beside(1, 2));
  bench.recorded.add(beside(2, 0));
  EXPECT_EQ(bench.recorded.largest_submap(bench.map.graph), 0);
  bench.recorded.add(beside(3, 2));
  EXPECT_EQ(bench.recorded.largest_submap(bench.map.graph), 1);
}

TEST(FrameTrajectory, RefiningGivesTheFrameThePoseOfItsLandmarks) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    PathBench bench(sensor);
    bench.recorded.add(bench.seeing(1, 1, pose_at(0.4), some_error));
    const auto pose = [&]() -> SE3 { return bench.recorded.trajectory(bench.map.graph, 0)[0].world_from_body; };
    EXPECT_THAT(pose(), pose_near(pose_at(0.4) * some_error, 1e-9, 1e-9));
    bench.recorded.refine(bench.map.graph, 30);
    EXPECT_THAT(pose(), pose_near(pose_at(0.4), 1e-4, 1e-4));
  }
}

TEST(FrameTrajectory, IsRefinedInAMapWhoseScaleHasChanged) {
  PathBench bench;
  bench.recorded.add(bench.seeing(1, 1, pose_at(0.4), some_error));
  const Sim3 grown(2.0, SO3(), {0.0, 0.0, 1.0});
  bench.map.graph.transform(0, grown);
  bench.recorded.refine(bench.map.graph, 30);
  const SE3 expected(pose_at(0.4).rotation(), grown * pose_at(0.4).translation());
  EXPECT_THAT(bench.recorded.trajectory(bench.map.graph, 0)[0].world_from_body, pose_near(expected, 2e-4, 1e-4));
  EXPECT_EQ(bench.recorded.frames()[0].unit, 2.0);
}

TEST(FrameTrajectory, AFrameWithTooFewInliersKeepsItsPose) {
  PathBench bench;
  TrackedFrame frame = bench.seeing(1, 1, pose_at(0.4), some_error);
  frame.measured = first_of(frame, 20);
  ASSERT_EQ(frame.measured->seen.front().landmark, 0) << "the first one counts as well";
  bench.recorded.add(frame);
  bench.recorded.refine(bench.map.graph, 21);
  EXPECT_THAT(bench.recorded.trajectory(bench.map.graph, 0)[0].world_from_body,
              pose_near(pose_at(0.4) * some_error, 1e-9, 1e-9));
  bench.recorded.refine(bench.map.graph, 20);
  EXPECT_THAT(bench.recorded.trajectory(bench.map.graph, 0)[0].world_from_body, pose_near(pose_at(0.4), 1e-4, 1e-4));
}

TEST(FrameTrajectory, RemovedLandmarksAreNotUsedAndFusedOnesAre) {
  PathBench bench;
  MapGraph& graph = bench.map.graph;
  TrackedFrame frame = bench.seeing(1, 1, pose_at(0.4), some_error);
  frame.measured = first_of(frame, 20);
  const std::int64_t first = frame.measured->seen[0].landmark, second = frame.measured->seen[1].landmark;
  bench.recorded.add(frame);
  // A duplicate at the position of the first landmark replaces it; the second is removed.
  const std::int64_t twin = graph.add_landmark(graph.landmark(first).position, 0).id;
  graph.fuse(twin, first);
  graph.remove_landmark(second);
  bench.recorded.refine(graph, 20);
  EXPECT_THAT(bench.recorded.trajectory(graph, 0)[0].world_from_body, pose_near(pose_at(0.4) * some_error, 1e-9, 1e-9));
  bench.recorded.refine(graph, 19);
  EXPECT_THAT(bench.recorded.trajectory(graph, 0)[0].world_from_body, pose_near(pose_at(0.4), 1e-4, 1e-4));
}

TEST(FrameTrajectory, LandmarksOfAnotherSubmapAreNotUsed) {
  PathBench bench;
  bench.map.add(2, SE3(), {}, 1);
  bench.recorded.add(bench.seeing(1, 2, pose_at(0.4), some_error));
  // All its landmarks belong to the first submap, which has another world.
  for (const std::int64_t id : bench.map.graph.landmark_ids()) bench.map.graph.remove_observation(2, id);
  bench.recorded.refine(bench.map.graph, 1);
  EXPECT_THAT(bench.recorded.trajectory(bench.map.graph, 1)[0].world_from_body,
              pose_near(pose_at(0.4) * some_error, 1e-9, 1e-9));
}

TEST(FrameTrajectory, AFrameThatBecameAKeyframeGetsItsPose) {
  PathBench bench;
  const SE3 elsewhere = pose_at(3.0);
  for (const int index : {1, 2, 3}) bench.recorded.add(frame_at(bench.map.graph, index, 0, pose_at(0.1 * index)));
  bench.recorded.set_keyframe(2, 1);
  bench.recorded.set_keyframe(7, 1);
  bench.map.graph.keyframe(1).camera_from_world = elsewhere.inverse();
  bench.recorded.refine(bench.map.graph, 10);
  const Trajectory poses = bench.recorded.trajectory(bench.map.graph, 0);
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_THAT(poses[0].world_from_body, pose_near(pose_at(0.1), 1e-9, 1e-9));
  EXPECT_THAT(poses[1].world_from_body, pose_near(elsewhere, 1e-9, 1e-9));
  EXPECT_EQ(poses[1].stamp, 2 * tenth);
  EXPECT_THAT(poses[2].world_from_body, pose_near(pose_at(0.3), 1e-9, 1e-9));
}

/// Refined beside tracking, in part, frames get the poses that refining all of them at the end gives.
TEST(FrameTrajectory, FramesRefinedElsewhereArePutBack) {
  PathBench bench;
  FrameTrajectory at_once;
  for (int index = 1; index <= 6; ++index) {
    const TrackedFrame frame = bench.seeing(index, index % 2, pose_at(0.15 * index), some_error);
    bench.recorded.add(frame);
    at_once.add(frame);
  }
  EXPECT_TRUE(bench.recorded.take_observed(4, 3).empty()) << "too few to be worth it";
  std::vector<TrackedFrame> taken = bench.recorded.take_observed(4, 2);
  ASSERT_EQ(taken.size(), 2U) << "the oldest";
  EXPECT_EQ(taken[1].index, 2);
  const auto observed = [](const TrackedFrame& frame) { return frame.measured != nullptr; };
  EXPECT_EQ(std::count_if(bench.recorded.frames().begin(), bench.recorded.frames().end(), observed), 4);
  for (TrackedFrame& frame : taken) refine_frame(frame, bench.map.graph, 15);
  taken.push_back(taken[0]);
  taken.back().index = 77;  // of a map that was dropped meanwhile
  taken.push_back(taken[1]);
  taken.back().index = 0;  // the same, before those that are left
  bench.recorded.put_back(taken);
  EXPECT_EQ(bench.recorded.frames().size(), 6U);
  EXPECT_TRUE(bench.recorded.take_observed(4, 1).empty()) << "they have no observations any more";
  bench.recorded.refine(bench.map.graph, 15);
  at_once.refine(bench.map.graph, 15);
  const Trajectory poses = bench.recorded.trajectory(bench.map.graph, 0), all = at_once.trajectory(bench.map.graph, 0);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_THAT(poses[k].world_from_body, pose_near(all[k].world_from_body, 1e-9, 1e-9)) << k;
    EXPECT_THAT(poses[k].world_from_body, pose_near(pose_at(0.15 * static_cast<double>(k + 1)), 1e-3, 1e-4)) << k;
  }
}

/// A camera that stays in one place for an hour gives 100,000 frames and hardly a keyframe.
TEST(FrameTrajectory, AFrameThatIsOnlyRememberedIsSmall) {
  PathBench bench(CameraKind::depth);
  for (int k = 1; k < 7; ++k) {
    TrackedFrame frame = bench.seeing(k, 0, pose_at(0.1 * k), SE3());
    frame.measured = with(frame, {});
    bench.recorded.add(frame);
  }
  EXPECT_GT(bench.recorded.bytes(), 6U * sizeof(DirectObservation));
  ASSERT_EQ(bench.recorded.take_observed(0, 6).size(), 6U);
  EXPECT_LE(bench.recorded.bytes(), 6U * 80U);
}

/// Whatever of it is kept where.
TEST(FrameTrajectory, AFrameComesBackAsItWasAdded) {
  PathBench bench(CameraKind::depth);
  TrackedFrame last;
  for (const std::int64_t index : {7, 3, 2'000'000'000, 5}) {
    TrackedFrame frame = bench.seeing(index % 100, index % 2, pose_at(0.013 * static_cast<double>(index % 100)), SE3());
    frame.index = index;
    frame.stamp = 1'700'000'000'000'000'000 + index;
    frame.unit = 1.0 / static_cast<double>(index);
    if (index != 5) frame.became = index % 3;
    if (index == 3) frame.measured.reset();
    bench.recorded.add(frame);
    const auto frames = bench.recorded.frames();
    const auto same = std::ranges::find_if(frames, [&](const TrackedFrame& other) { return other.index == index; });
    ASSERT_NE(same, frames.end());
    const TrackedFrame back = *same;
    EXPECT_EQ(back.stamp, frame.stamp);
    EXPECT_EQ(back.keyframe, frame.keyframe);
    EXPECT_EQ(back.unit, frame.unit);
    EXPECT_EQ(back.became, frame.became);
    EXPECT_EQ(back.measured, frame.measured);
    EXPECT_EQ(back.camera_from_keyframe.matrix(), frame.camera_from_keyframe.matrix());
    if (index == 2'000'000'000) last = frame;
  }
  ASSERT_TRUE(bench.recorded.repeat_last(2'000'000'001, last.stamp + 1));
  const TrackedFrame repeated = bench.recorded.frames().back();
  EXPECT_EQ(repeated.became, last.became);
  EXPECT_EQ(repeated.measured, last.measured);
  bench.recorded.forget(bench.map.graph, 0);
  EXPECT_TRUE(bench.recorded.frames().empty());
  EXPECT_EQ(bench.recorded.bytes(), 0U);
}

TEST(FrameTrajectory, WhereMemoryIsShortFramesAreRememberedOnly) {
  PathBench bench(CameraKind::depth);
  for (int k = 1; k < 7; ++k) {
    if (k == 4) bench.recorded.forget_observations();
    TrackedFrame frame = bench.seeing(k, 0, pose_at(0.1 * k), SE3());
    frame.measured = with(frame, {});
    bench.recorded.add(frame);
  }
  EXPECT_LE(bench.recorded.bytes(), 6U * 192U);
}

/// What whole images say of the pose counts with the features, by its certainty.
TEST(FrameTrajectory, RefinesWithTheDirectPose) {
  PathBench bench(CameraKind::depth);
  const SE3 by_features = pose_at(0.4), by_images = pose_at(0.4) * SE3(SO3(), {0.0, 0.0, 0.01});
  const SE3 relative = (bench.map.graph.camera_from_world(1) * by_images).inverse();
  for (const double sigma : {1e-7, 10.0}) {
    TrackedFrame frame = bench.seeing(3, 0, by_features, SE3(SO3(), {0.002, 0.0, 0.0}));
    frame.measured = with(frame, {1, {relative, sigma * sigma * Matrix6d::Identity()}});
    refine_frame(frame, bench.map.graph, 15);
    const SE3 refined = (frame.camera_from_keyframe * bench.map.graph.camera_from_world(0)).inverse();
    EXPECT_THAT(refined, pose_near(sigma < 1.0 ? by_images : by_features, 2e-4, 2e-4)) << sigma;
  }
}

}  // namespace
}  // namespace rastro
