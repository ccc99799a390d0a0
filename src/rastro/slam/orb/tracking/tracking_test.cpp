// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/tracking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/wall_run_testing.h"

namespace rastro {
namespace {

using testing::count_of;
using testing::pose_near;
using testing::wall_camera;
using testing::WallRun;

TEST(Tracking, OneCameraGetsMoreFeaturesWhileFewLandmarksAreTracked) {
  for (const int few : {0, 400}) {
    OrbSlamOptions options = WallRun::wall_options();
    options.few_tracked = few;
    options.enough_tracked = 400;
    options.init_trial_frames = 0;
    WallRun run(options, wall_camera(), CameraKind::mono);
    int tracked = 0;
    for (std::int64_t k = 0; k < 12 && tracked < 3; ++k)
      tracked += run.process(k, 0.08 * static_cast<double>(k)).state == SlamState::tracking;
    ASSERT_EQ(tracked, 3);
    EXPECT_EQ(run.tracking.observations().size(), few > 0 ? 600U : 400U);
  }
}

TEST(Tracking, ReportsPoseObservationsAndCovariance) {
  WallRun run;
  EXPECT_TRUE(run.tracking.observations().empty());
  EXPECT_EQ(run.process(0, 0.0).state, SlamState::tracking);
  const std::vector<FeatureObservation> first = run.tracking.observations();
  EXPECT_EQ(count_of(first, ObservationState::inlier), 0U) << "the map begins with this frame";
  EXPECT_GT(count_of(first, ObservationState::new_landmark), 100U);
  const std::vector<std::int64_t>& landmarks = run.session.graph.keyframe(0).landmarks;
  ASSERT_EQ(first.size(), landmarks.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].landmark, landmarks[i]) << i;
    EXPECT_EQ(first[i].state, landmarks[i] < 0 ? ObservationState::unmatched : ObservationState::new_landmark) << i;
  }
  const SlamUpdate update = run.process(1, 0.03);
  EXPECT_EQ(update.state, SlamState::tracking);
  EXPECT_EQ(update.reason, SlamReason::none);
  EXPECT_THAT(update.world_from_body, pose_near(run.beside(0.03), 0.01, 0.003));
  EXPECT_GT(update.used, 150);
  EXPECT_GT(update.score, 0.7);
  EXPECT_LE(update.score, 1.0);
  const auto observations = run.tracking.observations();
  EXPECT_EQ(count_of(observations, ObservationState::inlier), static_cast<std::size_t>(update.used));
  for (const FeatureObservation& o : observations) {
    const bool matched = o.state == ObservationState::inlier || o.state == ObservationState::outlier ||
                         o.state == ObservationState::matched;
    EXPECT_EQ(run.session.graph.has_landmark(o.landmark), matched) << name_of(o.state);
  }
  ASSERT_EQ(run.session.trajectory.frames().size(), 2U);
  EXPECT_EQ(run.session.trajectory.frames()[1].index, 1);
  EXPECT_EQ(run.session.trajectory.frames()[1].measured->seen.size(), static_cast<std::size_t>(update.used));
  ASSERT_TRUE(update.covariance);
  EXPECT_EQ(*update.covariance, update.covariance->transpose());
  const Vector6d error = (update.world_from_body * run.beside(0.03).inverse()).log();
  EXPECT_LT(error.cwiseAbs2().cwiseQuotient(update.covariance->diagonal()).maxCoeff(), 36.0);
}

TEST(Tracking, FewInliersAmongManyContradictionsAreWeak) {
  const auto second_of = [](int weak_inliers, double weak_share) {
    WallRun run;
    run.session.options.weak_inliers = weak_inliers;
    run.session.options.weak_share = weak_share;
    run.process(0, 0.0);
    return run.process(1, 0.03);
  };
  const SlamUpdate tracked = second_of(0, 1.0);
  ASSERT_LT(tracked.score, 1.0);
  EXPECT_EQ(tracked.state, SlamState::tracking);
  EXPECT_EQ(second_of(tracked.used, 1.0).state, SlamState::tracking) << "not fewer than that";
  EXPECT_EQ(second_of(tracked.used + 1, tracked.score).state, SlamState::tracking) << "not below that share";
  const SlamUpdate weak = second_of(tracked.used + 1, tracked.score + 1e-6);
  EXPECT_EQ(weak.state, SlamState::weak);
  EXPECT_EQ(weak.reason, SlamReason::few_inliers);
  EXPECT_TRUE(weak.detail.starts_with("only " + std::to_string(tracked.used) + " of ")) << weak.detail;
  EXPECT_TRUE(weak.covariance);
}

TEST(Tracking, TheCovarianceIsInTheAxesOfTheWorld) {
  WallRun run;
  run.process(0, 0.0);
  run.session.graph.transform(0, Sim3(1.0, SO3::exp({0.3, -0.4, 0.8}), {1.0, 2.0, 3.0}));
  run.tracker.set_view(view_of(run.session.graph, 0, run.session.view_options()));
  FrameTracker same = run.tracker;
  const Frame frame = run.frame_at(1, run.beside(0.03));
  const SlamUpdate update = run.process(frame);
  const TrackingResult in_camera =
      same.track(FeatureMaker(run.session.options, run.session.sensor, nullptr).make(frame));
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = axes.bottomRightCorner<3, 3>() = in_camera.camera_from_world.rotation().matrix();
  ASSERT_TRUE(update.covariance);
  const Matrix6d expected = axes.transpose() * in_camera.covariance * axes;
  EXPECT_GT((expected - in_camera.covariance).norm(), 0.1 * expected.norm());
  EXPECT_THAT(*update.covariance, testing::matrix_near(expected, 1e-9 * expected.norm()));
}

/// Yaw at 1 rad/s, read in 80 ms: by pieces of four rows.
Frame rolling_frame(std::int64_t index) {
  constexpr double rad_per_s = 1.0, readout_s = 0.08;
  constexpr int rows = 4;
  const auto at = [](double seconds) { return SE3(SO3::exp({0.0, rad_per_s * seconds, 0.0}), {0.0, 0.0, 0.0}); };
  const double middle_s = 0.1 * static_cast<double>(index);
  Frame frame = WallRun::frame_at(index, at(middle_s));
  for (int y = 0; y < frame.image.height(); y += rows) {
    const double seconds = ((y + 0.5 * rows) / frame.image.height() - 0.5) * readout_s;
    const GrayImage then = testing::image_of_wall(wall_camera(), at(middle_s + seconds));
    for (int row = y; row < y + rows; ++row) std::copy_n(then.row(row), then.width(), frame.image.row(row));
  }
  for (int y = 0; y < frame.depth.height(); ++y) {
    const double seconds = (y / (frame.depth.height() - 1.0) - 0.5) * readout_s;
    for (int x = 0; x < frame.depth.width(); ++x) {
      const Eigen::Vector2d ray = *wall_camera().unproject({x, y});
      const Eigen::Vector3d in_world = at(middle_s + seconds).rotation() * ray.homogeneous();
      frame.depth.at(x, y) = static_cast<float>(testing::wall_m / in_world.z());
    }
  }
  return frame;
}

TEST(Tracking, ARollingShutterIsCompensatedFromTheFirstFrameOn) {
  std::vector<Frame> frames;
  for (std::int64_t k = 0; k < 4; ++k) frames.push_back(rolling_frame(k));
  std::vector<double> errors;
  for (const double readout_s : {0.0, 0.08}) {
    Camera camera = wall_camera();
    camera.readout_s = readout_s;
    WallRun run(WallRun::wall_options(), camera);
    const SlamUpdate first = run.process(frames[0]);
    EXPECT_EQ(first.state == SlamState::initializing, readout_s > 0.0) << "its rotation is not known yet";
    EXPECT_EQ(first.reason == SlamReason::first_frame, readout_s > 0.0);
    double worst_m = 0.0;
    for (std::size_t k = 1; k < frames.size(); ++k) {
      const SlamUpdate update = run.process(frames[k]);
      EXPECT_EQ(update.state, SlamState::tracking) << k;
      worst_m = std::max(worst_m, update.world_from_body.translation().norm());
    }
    EXPECT_EQ(run.session.trajectory.frames().size(), frames.size()) << "the first one too";
    errors.push_back(worst_m);
  }
  EXPECT_LT(errors[1], 0.02) << "it only rotates";
  EXPECT_GT(errors[0], 2.0 * errors[1]);
}

/// The largest depth error of the keyframes made from frame 3 on, while the camera moves straight toward the wall and
/// depths are captured `offset` later than the images.
double depth_error(TimeNs offset) {
  OrbSlamOptions options = WallRun::wall_options();
  options.keyframe_frames = 1;
  WallRun run(options);
  const auto ahead = [](double z) { return SE3(SO3(), {0.0, 0.0, z}); };
  for (int k = 0; k < 5; ++k) {
    Frame frame = run.frame_at(k, ahead(0.05 * k));
    if (k >= 3) {
      frame.depth = run.depth_from(0.05 * (k + to_seconds(offset) / 0.1));
      frame.depth_stamp = frame.stamp + offset;
    }
    run.process(frame);
  }
  double largest = 0.0;
  std::size_t checked = 0;
  for (const std::int64_t id : run.session.graph.keyframe_ids()) {
    const ImageFeatures& data = run.session.graph.keyframe(id).frame->data();
    if (data.frame < 3) continue;
    const double ground_truth = testing::wall_m - 0.05 * static_cast<double>(data.frame);
    for (const float depth : data.depths) {
      if (!(depth > 0.0F)) continue;
      ++checked;
      largest = std::max(largest, std::abs(static_cast<double>(depth) - ground_truth));
    }
  }
  EXPECT_GT(checked, 150U);
  return largest;
}

TEST(Tracking, DepthsFromAnotherInstantAreMovedToThatOfTheImage) {
  EXPECT_LT(depth_error(40000000), 0.008) << "of 0.02 m";
  EXPECT_LT(depth_error(-100000000), 0.016) << "of 0.05 m, just within a frame";
  EXPECT_NEAR(depth_error(110000000), 0.055, 0.005) << "too late to say";
}

TEST(Tracking, UnusableFramesHaveAReason) {
  WallRun run;
  Frame blank = run.frame_at(0, SE3());
  blank.image = GrayImage(320, 240);
  const SlamUpdate dark = run.process(blank);
  EXPECT_EQ(dark.reason, SlamReason::dark_or_blank);
  EXPECT_EQ(dark.state, SlamState::initializing);
  run.process(1, 0.0);
  blank.index = 2;
  blank.stamp = 200000000;
  EXPECT_EQ(run.process(blank).state, SlamState::lost) << "now there is a map";
  Frame empty;
  empty.index = 3;
  empty.stamp = 300000000;
  EXPECT_EQ(run.process(empty).reason, SlamReason::no_data);
  EXPECT_TRUE(run.session.tracking);
  EXPECT_EQ(run.session.trajectory.frames().size(), 1U);
  EXPECT_EQ(run.process(4, 0.02).state, SlamState::tracking);
}

TEST(Tracking, AGapIsReportedAndTrackedOver) {
  WallRun run;
  for (int k = 0; k < 4; ++k) EXPECT_EQ(run.process(k, 0.01 * k).reason, SlamReason::none);
  const SlamUpdate after = run.process(10, 0.05);
  EXPECT_EQ(after.reason, SlamReason::gap);
  EXPECT_NE(after.detail, "");
  EXPECT_EQ(after.state, SlamState::tracking);
}

TEST(Tracking, ARepeatedFrameHasTheLastPoseIfItIsKnownAndLater) {
  WallRun run;
  run.process(0, 0.0);
  run.process(1, 0.02);
  Frame again = run.frame_at(1, run.beside(0.02));
  again.index = 2;
  again.stamp = 150000000;
  const SlamUpdate repeated = run.process(again);
  EXPECT_EQ(repeated.state, SlamState::weak) << "the camera may have moved on";
  EXPECT_EQ(repeated.reason, SlamReason::repeated_frame);
  ASSERT_EQ(run.session.trajectory.frames().size(), 3U);
  EXPECT_EQ(run.session.trajectory.frames()[2].index, 2);
  again.stamp = 50000000;
  EXPECT_EQ(run.process(again).state, SlamState::lost) << "a stamp that goes back";
  run.session.tracking = false;
  again.index = 3;
  again.stamp = 250000000;
  EXPECT_EQ(run.process(again).state, SlamState::lost);
  EXPECT_EQ(run.session.trajectory.frames().size(), 3U);
}

/// The camera leaps farther than landmarks are searched for around their predicted positions.
TEST(Tracking, TracksFollowALeapThatTheSearchDoesNot) {
  for (const char* frontend : {"orb", "tracks"}) {
    OrbSlamOptions options = WallRun::wall_options();
    options.frontend = frontend;
    options.search_px = options.local_search_px = 1.0;
    options.init_hamming = 1;  // or the reference keyframe would find it
    WallRun run(options);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(run.process(k, 0.0005 * k).state, SlamState::tracking) << k;
    const SlamUpdate leap = run.process(3, 0.2);
    EXPECT_EQ(leap.state == SlamState::tracking, options.frontend == "tracks");
    if (options.frontend == "tracks") {
      EXPECT_THAT(leap.world_from_body, pose_near(run.beside(0.2), 0.01, 0.003));
    }
  }
}

TEST(Tracking, KeyframesAreMadeWhileMappingAndTheViewFollowsTheCameraWithout) {
  OrbSlamOptions options = WallRun::wall_options();
  options.keyframe_frames = options.lost_frames = 1;
  for (const bool mapping : {true, false}) {
    WallRun run(options);
    run.process(0, 0.0);
    run.session.mapping = mapping;
    for (int k = 1; k < 4; ++k) run.process(k, 0.05 * k);
    EXPECT_EQ(run.session.next_keyframe > 1, mapping);
    if (mapping) {
      SlamUpdate update;
      run.pipeline.take_all_results(update.events);
      run.session.mapping = false;
      run.tracker.set_view(view_of(run.session.graph, 0, run.session.view_options()));
      const std::int64_t keyframes = run.session.next_keyframe;
      update = run.process(5, 0.18);
      EXPECT_GT(run.tracker.view()->center, 0) << "of the keyframe that shares most";
      EXPECT_EQ(run.session.next_keyframe, keyframes);
    }
    for (int k = 6; k < 9; ++k)
      EXPECT_TRUE(run.process(run.frame_at(k, SE3(SO3(), {40.0 + 0.05 * k, 30.0, 0.0}))).events.empty());
    EXPECT_EQ(run.session.graph.submap_count(), 1) << "no submap begins";
  }
}

}  // namespace
}  // namespace rastro
