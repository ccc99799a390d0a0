// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/initialization/initialization.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/session_testing.h"

namespace rastro {
namespace {

using testing::Observed;
using testing::ObserveOptions;
using testing::pose_near;
using testing::SessionBench;

struct InitializationBench : SessionBench {
  explicit InitializationBench(CameraKind sensor, const OrbSlamOptions& options = {},
                               testing::PointWorld points = testing::PointWorld(300, 5))
      : SessionBench(sensor, options, {}, std::move(points)), initialization(session, tracker, pipeline, keyframes) {}
  /// Frame `index` at a stop.
  SlamUpdate process(std::int64_t index, double k, const ObserveOptions& how = {}) {
    SlamUpdate update;
    initialization.process(observe(index, stop(k), how).frame, update);
    return update;
  }
  /// A map from frames 0 and 1, on trial.
  void begin_from_two_views() {
    process(0, 0.0);
    process(1, 2.0);
    ASSERT_TRUE(session.has_map);
  }
  /// Whether a frame whose landmarks fit this badly is the last before the map on trial is dropped.
  bool contradicts(double mean_squared) {
    TrackingResult result;
    result.reference = tracker.view()->center;
    result.mean_squared = mean_squared;
    return initialization.is_contradicted_by(observe(100, stop(2.0)).frame, result);
  }
  /// The frames' positions in the first submap, as recorded.
  std::vector<double> positions(int submap = 0) const {
    std::vector<double> xs;
    for (const StampedPose& pose : session.trajectory.trajectory(session.graph, submap))
      xs.push_back(pose.world_from_body.translation().x());
    return xs;
  }

  Initialization initialization;
};

TEST(Initialization, OneCameraInitializesWithTwoViews) {
  InitializationBench bench(CameraKind::mono);
  const SlamUpdate first = bench.process(0, 0.0);
  EXPECT_EQ(first.reason, SlamReason::first_frame);
  EXPECT_EQ(first.detail, "the first frame");
  const SlamUpdate near = bench.process(1, 0.1);
  EXPECT_EQ(near.reason, SlamReason::too_few_points);
  EXPECT_THAT(near.detail, ::testing::StartsWith("median parallax"));
  EXPECT_FALSE(bench.session.has_map);
  const SlamUpdate begun = bench.process(2, 2.0);
  EXPECT_TRUE(bench.session.has_map);
  EXPECT_TRUE(bench.session.tracking);
  EXPECT_EQ(begun.state, SlamState::tracking);
  EXPECT_EQ(begun.reason, SlamReason::none);
  EXPECT_EQ(begun.detail, "");
  ASSERT_EQ(begun.events.size(), 1U);
  EXPECT_EQ(begun.events[0].kind, "submap");
  EXPECT_THAT(begun.events[0].detail, ::testing::MatchesRegex("0 started from frames 0 and 2 with (299|300) points"));
  EXPECT_EQ(bench.session.next_keyframe, 2);
  EXPECT_EQ(bench.session.graph.keyframe_ids(), (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(bench.session.graph.keyframe(0).frame->data().frame, 0);
  EXPECT_EQ(bench.session.graph.keyframe(1).frame->data().frame, 2);
  const SE3 second = bench.session.graph.camera_from_world(1).inverse();
  EXPECT_THAT(begun.world_from_body, pose_near(second, 1e-3, 1e-3));
  EXPECT_EQ(bench.tracker.view()->center, 1);
}

TEST(Initialization, FramesBeforeAndBetweenTheTwoViewsGetTheirPoses) {
  InitializationBench bench(CameraKind::mono);
  // Too few points to initialize, but enough for tracking backward; and less than a keyframe must share.
  bench.process(0, 0.0, {.to = 80});
  std::int64_t index = 1;
  for (; index < 20 && !bench.session.has_map; ++index) bench.process(index, 0.2 * static_cast<double>(index));
  ASSERT_TRUE(bench.session.has_map);
  const auto& frames = bench.session.trajectory.frames();
  ASSERT_EQ(frames.size(), static_cast<std::size_t>(index));
  EXPECT_GT(index, 3);
  const std::vector<double> xs = bench.positions();
  const double unit = (xs.back() - xs[1]) / static_cast<double>(index - 2);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].index, static_cast<std::int64_t>(i));
    EXPECT_NEAR(xs[i], unit * (static_cast<double>(i) - 1.0), 0.02 * unit) << i;
  }
  EXPECT_EQ(frames[1].became, 0);
  EXPECT_EQ(frames.back().became, 1);
  EXPECT_EQ(frames[0].became, 2);
  EXPECT_EQ(bench.session.graph.keyframe_ids(), (std::vector<std::int64_t>{0, 1, 2})) << "one made of the frame before";
  EXPECT_EQ(bench.session.graph.keyframe(2).frame->data().frame, 0);
  EXPECT_THAT(bench.tracker.last_pose().inverse().translation().x(), ::testing::DoubleNear(xs.back(), 0.01 * unit));
}

TEST(Initialization, ASubmapBeginsOnlyAfterRelocalizationFailedLongEnough) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    InitializationBench bench(sensor);
    bench.begin(3);
    bench.session.frame_number = 10;
    bench.pipeline.insert(bench.input(10, 2.2, 2), 0);
    bench.session.tracking = false;
    bench.session.lost_frames = 29;
    bench.process(20, 0.0);
    EXPECT_TRUE(bench.process(21, 2.0).events.empty());
    EXPECT_EQ(bench.session.graph.submap_count(), 1);
    EXPECT_FALSE(bench.pipeline.idle());
    bench.session.lost_frames = 30;
    const SlamUpdate update = bench.process(22, 2.5);
    ASSERT_EQ(update.events.size(), 1U);
    EXPECT_THAT(update.events[0].detail,
                ::testing::MatchesRegex("1 started (from frames 20 and 22 )?with (29[0-9]|300) points"))
        << "not those of both submaps";
    EXPECT_TRUE(bench.session.tracking);
    EXPECT_TRUE(bench.pipeline.idle()) << "mapping was waited for";
    const std::vector<std::int64_t> made = bench.session.graph.keyframe_ids(1);
    EXPECT_EQ(made.front(), 4);
    EXPECT_EQ(bench.session.next_keyframe, sensor == CameraKind::mono ? 6 : 5);
    EXPECT_EQ(bench.tracker.view()->center, made.back());
  }
}

TEST(Initialization, WithDepthOneFrameOfEnoughPointsInitializes) {
  InitializationBench bench(CameraKind::depth);
  const SlamUpdate few = bench.process(0, 0.0, {.to = 199});
  EXPECT_EQ(few.reason, SlamReason::too_few_points);
  EXPECT_EQ(few.detail, "needs at least 200 features with depth, got 199");
  EXPECT_FALSE(bench.session.has_map);
  const SlamUpdate begun = bench.process(1, 0.0, {.to = 200});
  EXPECT_EQ(begun.state, SlamState::tracking);
  EXPECT_EQ(begun.reason, SlamReason::none);
  ASSERT_EQ(begun.events.size(), 1U);
  EXPECT_EQ(begun.events[0].kind, "submap");
  EXPECT_EQ(begun.events[0].detail, "0 started with 200 points");
  EXPECT_THAT(begun.world_from_body, pose_near(SE3(), 0.0, 0.0));
  EXPECT_EQ(bench.session.graph.landmark_count(), 200U);
  EXPECT_EQ(bench.session.next_keyframe, 1);
  ASSERT_EQ(bench.session.trajectory.frames().size(), 1U);
  EXPECT_EQ(bench.session.trajectory.frames()[0].index, 1);
  EXPECT_EQ(bench.session.trajectory.frames()[0].became, 0);
  const TrackingResult next = bench.tracker.track(bench.observe(2, bench.stop(0.2)).frame);
  EXPECT_TRUE(next.ok);
  EXPECT_GT(next.predicted, 180) << "by the points of the first frame";
}

/// Of 300 points with depth, a quarter is near.
TEST(Initialization, WithDepthAMapBeginsWithNearPoints) {
  OrbSlamOptions options;
  options.far_baselines = 15.0;  // 6 m
  InitializationBench bench(CameraKind::depth, options);
  const SlamUpdate begun = bench.process(0, 0.0);
  ASSERT_TRUE(bench.session.has_map);
  const std::size_t landmarks = bench.session.graph.landmark_count();
  EXPECT_GE(landmarks, 30U);
  EXPECT_LT(landmarks, 200U);
  EXPECT_EQ(begun.events[0].detail, "0 started with " + std::to_string(landmarks) + " points");
}

TEST(Initialization, WithFewerNearPointsThanTrackingNeedsNoMapBegins) {
  OrbSlamOptions options;
  options.far_baselines = 10.25;  // 4.1 m
  InitializationBench bench(CameraKind::depth, options);
  for (int k = 0; k < 15; ++k) {
    const SlamUpdate waits = bench.process(k, 0.02 * k);
    EXPECT_EQ(waits.reason, SlamReason::too_few_points);
    EXPECT_THAT(waits.detail, ::testing::MatchesRegex("needs at least 200 features with depth, got (29[0-9]|300), but "
                                                      "only [0-9]+ of them within 4.1 m, of which 30 are needed"));
    EXPECT_FALSE(bench.session.has_map);
  }
}

/// Keyframes before the first one make the second redundant; then it is too far away to be tracked.
TEST(Initialization, TrackingGoesOnFromTheFirstViewWhereTheSecondWasCulled) {
  OrbSlamOptions options;
  options.search_px = 1.0;
  options.min_guess_inliers = 1000;  // the reference keyframe would find it
  options.cull_seen_share = 0.5;
  InitializationBench bench(CameraKind::mono, options);
  bench.process(0, 0.0, {.to = 60});
  bench.process(1, 0.03, {.to = 80});
  bench.process(2, 0.06);
  ASSERT_FALSE(bench.session.has_map);
  bench.process(3, 2.0);
  ASSERT_TRUE(bench.session.has_map);
  EXPECT_TRUE(bench.session.tracking);
  ASSERT_EQ(bench.session.graph.keyframe_ids(), (std::vector<std::int64_t>{0, 2, 3})) << "those before the first";
  EXPECT_THAT(bench.tracker.last_pose(), pose_near(bench.session.graph.camera_from_world(0), 1e-12, 1e-12));
  EXPECT_EQ(bench.positions().size(), 4U);
  EXPECT_TRUE(bench.tracker.track(bench.observe(4, bench.stop(0.09)).frame).ok);
}

TEST(Initialization, KeyframesAreCountedFromTheInitialization) {
  InitializationBench bench(CameraKind::depth);
  bench.session.frame_number = 100;
  bench.process(0, 0.0);
  TrackingResult result = bench.tracked(bench.observe(1, bench.stop(0.1)), bench.stop(0.1), 0);
  result.inliers = 299;
  bench.session.frame_number = 120;
  EXPECT_FALSE(bench.keyframes.needs_keyframe(*bench.observe(1, bench.stop(0.1)).frame, result));
  bench.session.frame_number = 121;
  EXPECT_TRUE(bench.keyframes.needs_keyframe(*bench.observe(1, bench.stop(0.1)).frame, result));
}

TEST(Initialization, AMapOnTrialIsDroppedAfterThreeContradictingFramesInARow) {
  InitializationBench bench(CameraKind::mono);
  bench.begin_from_two_views();
  for (int k = 0; k < 4; ++k) EXPECT_FALSE(bench.contradicts(1.5)) << "at the limit is within it";
  for (int k = 0; k < 2; ++k) EXPECT_FALSE(bench.contradicts(1.51));
  EXPECT_FALSE(bench.contradicts(1.0));
  for (int k = 0; k < 2; ++k) EXPECT_FALSE(bench.contradicts(1.51));
  EXPECT_TRUE(bench.contradicts(1.51));
}

TEST(Initialization, NoMapIsDroppedWithoutATrialOrAfterIt) {
  for (const int trial : {0, 2, 3}) {
    OrbSlamOptions options;
    options.init_trial_frames = trial;
    InitializationBench bench(CameraKind::mono, options);
    bench.begin_from_two_views();
    for (int k = 0; k < 2; ++k) EXPECT_FALSE(bench.contradicts(9.0));
    EXPECT_EQ(bench.contradicts(9.0), trial == 3);
    if (trial == 3) continue;
    // The frames kept for another initialization are dropped.
    bench.session.has_map = false;
    EXPECT_EQ(bench.process(200, 0.0).reason, SlamReason::first_frame);
  }
  InitializationBench reset(CameraKind::mono);
  reset.begin_from_two_views();
  reset.initialization.reset();
  for (int k = 0; k < 4; ++k) EXPECT_FALSE(reset.contradicts(9.0));
  reset.session.has_map = false;
  EXPECT_EQ(reset.process(200, 0.0).reason, SlamReason::first_frame);
}

TEST(Initialization, ContradictionsOfAnEarlierTrialDoNotCount) {
  OrbSlamOptions options;
  options.init_trial_frames = 2;
  InitializationBench bench(CameraKind::mono, options);
  bench.begin_from_two_views();
  for (int k = 0; k < 2; ++k) EXPECT_FALSE(bench.contradicts(9.0));
  bench.session.tracking = false;
  bench.session.lost_frames = 30;
  bench.process(20, 0.0);
  ASSERT_EQ(bench.process(21, 2.0).events.size(), 1U) << "another submap, on trial";
  EXPECT_FALSE(bench.contradicts(9.0));
}

TEST(Initialization, ADroppedMapLeavesNothingAndTheKeptFramesInitializeAgain) {
  InitializationBench bench(CameraKind::mono);
  bench.begin_from_two_views();
  SlamUpdate update;
  bench.keyframes.insert(bench.observe(2, bench.stop(2.2)).frame,
                         bench.tracker.track(bench.observe(2, bench.stop(2.2)).frame), update);
  TrackingResult last;
  last.reference = 1;
  last.mean_squared = 2.34;
  update.events.clear();
  bench.initialization.drop_map(last, update);
  EXPECT_EQ(bench.session.graph.keyframe_count(), 0U);
  EXPECT_EQ(bench.session.graph.landmark_count(), 0U);
  EXPECT_TRUE(bench.session.trajectory.frames().empty());
  EXPECT_FALSE(bench.session.tracking);
  EXPECT_FALSE(bench.session.has_map);
  EXPECT_EQ(bench.session.lost_frames, 0);
  ASSERT_EQ(update.events.size(), 1U);
  EXPECT_EQ(update.events[0].kind, "start_dropped");
  EXPECT_EQ(
      update.events[0].detail,
      "submap 0 contradicts the frames after it: mean squared error 2.3, at most 1.5; initialization begins again");
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(bench.contradicts(9.0)) << "nothing is on trial";
  const SlamUpdate again = bench.process(3, 2.4);
  ASSERT_EQ(again.events.size(), 1U);
  EXPECT_THAT(again.events[0].detail, ::testing::StartsWith("0 started "));
  EXPECT_EQ(bench.session.graph.keyframe_ids(), (std::vector<std::int64_t>{3, 4}));
}

TEST(Initialization, DoesNotHideWhyTrackingWasLost) {
  InitializationBench bench(CameraKind::mono);
  bench.begin(3);
  bench.session.tracking = false;
  SlamUpdate lost;
  lost.reason = SlamReason::few_inliers;
  lost.detail = "needs at least 30 inliers, got 5 of 40 matches";
  bench.initialization.process(bench.observe(20, bench.stop(0.0)).frame, lost);
  EXPECT_EQ(lost.detail, "needs at least 30 inliers, got 5 of 40 matches");
  EXPECT_EQ(lost.reason, SlamReason::few_inliers);
  SlamUpdate later;
  later.reason = SlamReason::not_found;
  bench.initialization.process(bench.observe(21, bench.stop(0.1)).frame, later);
  EXPECT_THAT(later.detail, ::testing::StartsWith("a new submap waits: median parallax"));
  EXPECT_EQ(later.reason, SlamReason::not_found);
}

TEST(Initialization, ADroppedSubmapLeavesTheOthersAndItsNumberIsReused) {
  InitializationBench bench(CameraKind::mono);
  bench.begin(3);
  TrackedFrame kept;
  kept.keyframe = 1;
  bench.session.trajectory.add(kept);
  bench.session.tracking = false;
  bench.session.lost_frames = 30;
  bench.process(20, 0.0);
  bench.process(21, 2.0);
  ASSERT_EQ(bench.session.graph.keyframe_ids(1).size(), 2U);
  EXPECT_EQ(bench.positions(1).size(), 2U);
  bench.session.lost_frames = 0;
  TrackingResult last;
  last.reference = 4;
  SlamUpdate update;
  bench.initialization.drop_map(last, update);
  EXPECT_EQ(bench.session.graph.keyframe_ids(), (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(bench.session.trajectory.frames().size(), 1U);
  EXPECT_TRUE(bench.session.has_map);
  EXPECT_FALSE(bench.session.tracking);
  EXPECT_EQ(bench.session.lost_frames, 30) << "the next submap may begin at once";
  const SlamUpdate again = bench.process(22, 2.2);
  ASSERT_EQ(again.events.size(), 1U);
  EXPECT_THAT(again.events[0].detail, ::testing::StartsWith("1 started "));
}

TEST(Initialization, ASubmapThatWasJoinedMeanwhileIsNotDropped) {
  InitializationBench bench(CameraKind::mono);
  bench.begin(3);
  bench.session.tracking = false;
  bench.session.lost_frames = 30;
  bench.process(20, 0.0);
  bench.process(21, 2.0);
  ASSERT_EQ(bench.session.graph.keyframe_ids(1).size(), 2U);
  bench.session.graph.merge(1, 0, Sim3(), 3, 2);
  TrackingResult last;
  last.reference = 4;
  SlamUpdate update;
  EXPECT_FALSE(bench.initialization.drop_map(last, update));
  EXPECT_EQ(bench.session.graph.keyframe_ids(0).size(), 5U);
  EXPECT_TRUE(bench.session.has_map);
  EXPECT_TRUE(update.events.empty());
  EXPECT_FALSE(bench.initialization.is_on_trial());
}

}  // namespace
}  // namespace rastro
