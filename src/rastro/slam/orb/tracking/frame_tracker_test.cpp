// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/frame_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::Observed;
using testing::ObserveOptions;
using testing::PointWorld;
using testing::pose_near;

double baseline_of(CameraKind sensor) { return sensor == CameraKind::mono ? 0.0 : 0.1; }

SE3 at(double x) { return SE3(SO3(), {-x, 0.0, 0.0}); }

/// Camera poses near the second keyframe, which is at x = 0.3.
SE3 near_keyframe() { return SE3(SO3::exp({0.004, -0.006, 0.01}), {-0.32, 0.02, -0.05}); }

SE3 upside_down() { return SE3(SO3::exp({0.05, 0.03, 3.0}), {-0.2, 0.1, 0.1}); }

/// A map of two keyframes and a tracker at the second.
struct TrackingBench {
  explicit TrackingBench(CameraKind sensor = CameraKind::mono, int points = 300)
      : world(points, 5),
        map(world, sensor, baseline_of(sensor)),
        tracker({}, world.camera, sensor, baseline_of(sensor)) {
    map.add(0, at(0.0));
    map.add(1, at(0.3));
    tracker.set_view(view_of(map.graph, 1, {}));
    const Observed last = observe(1, at(0.3));
    tracker.restart(at(0.3), map.tracked(last), last.frame);
  }
  Observed observe(std::int64_t id, const SE3& camera_from_world, ObserveOptions options = {}) const {
    options.baseline = map.graph.baseline();
    return world.observe(id, camera_from_world, options);
  }

  PointWorld world;
  ExactMap map;
  FrameTracker tracker;
};

/// Number of features that do not observe the landmark assigned to them.
std::size_t wrong_points(const TrackingBench& bench, const TrackingResult& result, const Observed& observed) {
  std::size_t wrong = 0;
  for (const TrackedPoint& point : result.points)
    wrong += bench.map.landmark_of[observed.seen[point.feature]] != point.landmark;
  return wrong;
}

class FrameTrackerTest : public ::testing::TestWithParam<CameraKind> {};

TEST_P(FrameTrackerTest, FindsThePoseAndTheLandmarksOfAnExactFrame) {
  TrackingBench bench(GetParam());
  const Observed observed = bench.observe(7, near_keyframe());
  const TrackingResult result = bench.tracker.track(observed.frame);
  ASSERT_TRUE(result.ok);
  EXPECT_THAT(result.camera_from_world, pose_near(near_keyframe(), 1e-4, 1e-5));
  EXPECT_EQ(wrong_points(bench, result, observed), 0U);
  EXPECT_EQ(result.points.size(), static_cast<std::size_t>(result.inliers));
  EXPECT_GT(result.points.size(), observed.seen.size() * 95 / 100);
  EXPECT_LE(result.inliers, result.matches);
  std::vector<std::int64_t> expected;
  for (const std::uint32_t point : observed.seen) expected.push_back(bench.map.landmark_of[point]);
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(result.visible, expected);
  EXPECT_THAT(bench.tracker.last_pose(), pose_near(near_keyframe(), 1e-4, 1e-5));
}

TEST_P(FrameTrackerTest, ThePoseIsRobustToNoiseAndOutliers) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    TrackingBench bench(GetParam());
    const Observed observed = bench.observe(7, near_keyframe(), {.noise_px = 1.0, .moved_share = 0.25, .seed = seed});
    const TrackingResult result = bench.tracker.track(observed.frame);
    ASSERT_TRUE(result.ok);
    EXPECT_THAT(result.camera_from_world, pose_near(near_keyframe(), 0.04, 0.005));
    EXPECT_EQ(wrong_points(bench, result, observed), 0U);
    EXPECT_GT(result.inliers, 180);
    EXPECT_LT(result.inliers, 235) << "a quarter is somewhere else";
  }
}

/// Squared errors in sigmas have the mean of a chi-square with six degrees of freedom.
TEST_P(FrameTrackerTest, CovarianceIsConsistentWithTheSpreadOfPoses) {
  constexpr int runs = 60;
  Vector6d squares = Vector6d::Zero(), variances = Vector6d::Zero();
  double sum = 0.0, fit = 0.0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    TrackingBench bench(GetParam());
    const Observed observed = bench.observe(7, near_keyframe(), {.noise_px = 1.0, .seed = seed});
    const TrackingResult result = bench.tracker.track(observed.frame);
    ASSERT_TRUE(result.ok);
    const Eigen::LLT<Matrix6d> factor(result.covariance);
    ASSERT_EQ(factor.info(), Eigen::Success) << "not positive definite";
    EXPECT_LT((result.covariance - result.covariance.transpose()).norm(), 1e-12);
    const Vector6d error = (near_keyframe() * result.camera_from_world.inverse()).log();
    sum += error.dot(factor.solve(error));
    squares += error.cwiseAbs2();
    variances += result.covariance.diagonal();
    fit += result.mean_squared / runs;
  }
  EXPECT_GT(sum / runs, 4.0);
  EXPECT_LT(sum / runs, 8.5);
  const Vector6d ratio = squares.cwiseQuotient(variances);
  EXPECT_GT(ratio.minCoeff(), 0.5);
  EXPECT_LT(ratio.maxCoeff(), 1.9);
  const double rows = GetParam() == CameraKind::mono ? 2.0 : 3.0;
  EXPECT_NEAR(fit, 0.9 * rows, 0.25) << "squares of one sigma each, less those taken for outliers";
}

TEST_P(FrameTrackerTest, TooFewMatchesGiveNoPoseAndLeaveTheTrackerUnchanged) {
  TrackingBench bench(GetParam());
  const Observed few = bench.observe(7, near_keyframe(), {.from = 0, .to = 25});
  const TrackingResult result = bench.tracker.track(few.frame);
  EXPECT_FALSE(result.ok);
  EXPECT_LE(result.inliers, 25);
  EXPECT_THAT(bench.tracker.last_pose(), pose_near(at(0.3), 0.0, 0.0));
  EXPECT_THAT(bench.tracker.predicted(), pose_near(at(0.3), 0.0, 0.0));
  const Observed enough = bench.observe(8, near_keyframe(), {.from = 0, .to = 40});
  EXPECT_TRUE(bench.tracker.track(enough.frame).ok);
}

TEST_P(FrameTrackerTest, NothingOfAnotherWorldIsMatched) {
  TrackingBench bench(GetParam());
  const PointWorld other(300, 99);
  const Observed observed = other.observe(7, near_keyframe(), {.baseline = bench.map.graph.baseline()});
  const TrackingResult result = bench.tracker.track(observed.frame);
  EXPECT_FALSE(result.ok);
  EXPECT_EQ(result.points.size(), 0U);
  EXPECT_GT(result.visible.size(), 200U) << "that should have been seen";
}

TEST_P(FrameTrackerTest, PredictsConstantVelocity) {
  TrackingBench bench(GetParam());
  const SE3 step(SO3::exp({0.0, 0.01, 0.005}), {-0.03, 0.0, 0.01});
  SE3 pose = at(0.3);
  for (int k = 0; k < 4; ++k) {
    pose = step * pose;
    ASSERT_TRUE(bench.tracker.track(bench.observe(7 + k, pose).frame).ok);
    EXPECT_THAT(bench.tracker.velocity(), pose_near(step, 2e-4, 2e-5));
    EXPECT_THAT(bench.tracker.predicted(), pose_near(step * pose, 3e-4, 3e-5));
  }
  // A tracker that was given a pose has zero velocity there.
  ASSERT_TRUE(bench.tracker.track_from(bench.observe(20, near_keyframe()).frame, near_keyframe()).ok);
  EXPECT_THAT(bench.tracker.predicted(), pose_near(near_keyframe(), 1e-4, 1e-5));
}

TEST_P(FrameTrackerTest, AJerkBeyondEverySearchIsFoundFromTheKeyframe) {
  TrackingBench bench(GetParam());
  const Observed observed = bench.observe(7, upside_down());
  const TrackingResult result = bench.tracker.track(observed.frame);
  EXPECT_LT(result.predicted, OrbSlamOptions{}.min_guess_inliers);
  ASSERT_TRUE(result.ok);
  EXPECT_THAT(result.camera_from_world, pose_near(upside_down(), 2e-4, 2e-5));
}

TEST_P(FrameTrackerTest, TrackedLandmarksReplaceTheSearch) {
  TrackingBench bench(GetParam());
  const SE3 rotated(SO3::exp({0.05, 0.1, 0.6}), {-0.2, 0.1, 0.1});
  const Observed observed = bench.observe(7, rotated);
  std::vector<LandmarkTrack> followed;
  for (std::uint32_t feature = 0; feature < 60; ++feature)
    followed.push_back({bench.map.landmark_of[observed.seen[feature]], observed.frame->ray(feature)});
  for (int k = 0; k < 10; ++k) followed[static_cast<std::size_t>(k)].ray += Eigen::Vector2d(0.2, -0.1);
  followed.push_back({123456, Eigen::Vector2d(0.1, 0.1)});
  const TrackingResult result = bench.tracker.track(observed.frame, followed);
  EXPECT_EQ(result.predicted, 50) << "of 60, 10 are wrong; one more is none of this map's";
  ASSERT_TRUE(result.ok);
  EXPECT_THAT(result.camera_from_world, pose_near(rotated, 2e-4, 2e-5));
}

INSTANTIATE_TEST_SUITE_P(Sensors, FrameTrackerTest, ::testing::Values(CameraKind::mono, CameraKind::depth));

/// The keyframes are 0.3 m apart, across the viewing direction: a disparity has the errors of its two features.
TEST(FrameTracker, CovariancesOfLandmarksAreThoseOfTriangulation) {
  const TrackingBench bench;
  const auto view = view_of(bench.map.graph, 1, {.covariances = true});
  ASSERT_EQ(view->covariances.size(), view->size());
  for (std::size_t i = 0; i < view->size(); ++i) {
    const MapLandmark& landmark = bench.map.graph.landmark(view->ids[i]);
    if (landmark.observations.size() < 2) continue;
    double variance = 0.0;
    for (const LandmarkObservation& o : landmark.observations) {
      const double sigma = bench.map.graph.sigma(*bench.map.graph.keyframe(o.keyframe).frame, o.feature);
      variance += sigma * sigma;
    }
    const double depth = landmark.position.z(), expected = std::sqrt(variance) * depth * depth / 0.3;
    // Less the prior that a point is at any distance at all.
    EXPECT_NEAR(std::sqrt(view->covariances[i](2, 2)), expected, 0.03 * expected);
  }
}

TEST(FrameTracker, LandmarksOfUnknownDistanceDoNotSupportAPoseInAGivenMap) {
  const TrackingBench bench;
  const Observed observed = bench.observe(7, near_keyframe());
  const auto result_with = [&](double distance_error, bool covariances) {
    OrbSlamOptions options;
    options.localization_distance_error = distance_error;
    FrameTracker tracker(options, bench.world.camera, CameraKind::mono, 0.0);
    tracker.set_view(view_of(bench.map.graph, 1, {.covariances = covariances}));
    tracker.restart(at(0.3), {}, bench.observe(1, at(0.3)).frame);
    return tracker.track_from(observed.frame, near_keyframe());
  };
  const TrackingResult mapping = result_with(0.05, false);
  EXPECT_EQ(mapping.supporting, mapping.inliers) << "a map that is being made corrects its landmarks";
  EXPECT_TRUE(mapping.ok);
  const TrackingResult all = result_with(0.0, true);
  EXPECT_EQ(all.supporting, all.inliers);
  const TrackingResult some = result_with(0.14, true), none = result_with(0.05, true);
  EXPECT_GT(some.supporting, some.inliers / 5) << "about half: near ones are seen in coarse levels";
  EXPECT_LT(some.supporting, some.inliers * 4 / 5);
  EXPECT_EQ(none.supporting, 0);
  EXPECT_GT(none.inliers, 200);
  EXPECT_FALSE(none.ok);
}

TEST(FrameTracker, TheReferenceIsTheKeyframeThatSharesMost) {
  const PointWorld world(300, 5);
  ExactMap map(world, CameraKind::mono, 0.0);
  map.add(0, at(0.0), {.from = 0, .to = 200});
  map.add(1, at(0.1), {.from = 100, .to = 300});
  FrameTracker tracker({}, world.camera, CameraKind::mono, 0.0);
  tracker.set_view(view_of(map.graph, 1, {}));
  const Observed left = world.observe(7, at(0.1), {.from = 0, .to = 140});
  EXPECT_EQ(tracker.track_from(left.frame, at(0.1)).reference, 0);
  const Observed right = world.observe(8, at(0.1), {.from = 160, .to = 300});
  EXPECT_EQ(tracker.track_from(right.frame, at(0.1)).reference, 1);
}

/// The keyframe in the middle of the view observes none of what the frame after the jerk shows.
TEST(FrameTracker, AJerkIsFoundFromTheReferenceOfTheLastFrame) {
  const PointWorld world(300, 5);
  ExactMap map(world, CameraKind::mono, 0.0);
  map.add(0, at(0.0), {.from = 0, .to = 200});
  map.add(1, at(0.1), {.from = 100, .to = 300});
  FrameTracker tracker({}, world.camera, CameraKind::mono, 0.0);
  tracker.set_view(view_of(map.graph, 1, {}));
  ASSERT_TRUE(tracker.track_from(world.observe(7, at(0.1), {.from = 0, .to = 140}).frame, at(0.1)).ok);
  const TrackingResult result = tracker.track(world.observe(8, upside_down(), {.from = 0, .to = 100}).frame);
  ASSERT_TRUE(result.ok);
  EXPECT_THAT(result.camera_from_world, pose_near(upside_down(), 2e-4, 2e-5));
}

TEST(FrameTracker, PoseAndVelocityMoveWithTheMap) {
  TrackingBench bench;
  const SE3 step(SO3::exp({0.0, 0.01, 0.005}), {-0.03, 0.0, 0.01});
  ASSERT_TRUE(bench.tracker.track(bench.observe(7, step * at(0.3)).frame).ok);
  const Sim3 grown(2.0, SO3::exp({0.3, -0.2, 0.1}), {1.0, 2.0, 3.0});
  bench.map.graph.transform(0, grown);
  bench.tracker.set_view(view_of(bench.map.graph, 1, {}));
  const auto moved = [&](const SE3& camera_from_world) -> SE3 {
    const SE3 pose = camera_from_world.inverse();
    return SE3(grown.rotation() * pose.rotation(), grown * pose.translation()).inverse();
  };
  EXPECT_THAT(bench.tracker.last_pose(), pose_near(moved(step * at(0.3)), 4e-4, 4e-5));
  EXPECT_THAT(bench.tracker.velocity(), pose_near(SE3(step.rotation(), 2.0 * step.translation()), 4e-4, 4e-5));
  const TrackingResult next = bench.tracker.track(bench.observe(8, step * step * at(0.3)).frame);
  ASSERT_TRUE(next.ok);
  EXPECT_GT(next.predicted, 200);
  EXPECT_THAT(next.camera_from_world, pose_near(moved(step * step * at(0.3)), 4e-4, 4e-5));
}

TEST(FrameTracker, DistinctiveLandmarksFitNoPoseByChance) {
  const TrackingBench bench;
  const Observed observed = bench.observe(7, near_keyframe());
  EXPECT_LT(bench.tracker.chance_inliers(*observed.frame, near_keyframe()), 1.0);
}

/// Where all look alike, points elsewhere fit any pose.
TEST(FrameTracker, APoseNoBetterThanChanceIsNoPose) {
  const auto alike = [](std::uint64_t seed) {
    PointWorld world(1500, seed);
    std::fill(world.descriptors.begin(), world.descriptors.end(), Descriptor{});
    return world;
  };
  const PointWorld here = alike(5), elsewhere = alike(99);
  ExactMap map(here, CameraKind::mono, 0.0);
  map.add(0, at(0.0));
  for (const double ratio : {0.0, 3.0}) {
    OrbSlamOptions options;
    options.match_ratio = 1.0;
    options.min_chance_ratio = ratio;
    FrameTracker tracker(options, here.camera, CameraKind::mono, 0.0);
    tracker.set_view(view_of(map.graph, 0, {}));
    const Observed last = here.observe(1, at(0.0));
    tracker.restart(at(0.0), map.tracked(last), last.frame);
    const TrackingResult result = tracker.track(elsewhere.observe(7, at(0.0)).frame);
    ASSERT_GT(result.inliers, 100);
    EXPECT_EQ(result.ok, ratio == 0.0);
    if (ratio == 0.0) continue;
    EXPECT_GT(3.0 * result.chance_inliers, result.inliers);
    EXPECT_THAT(tracker.last_pose(), pose_near(at(0.0), 0.0, 0.0)) << "it stays where it was";
  }
}

std::vector<std::uint32_t> all_features(const FeatureFrame& frame) {
  std::vector<std::uint32_t> features(frame.size());
  for (std::uint32_t i = 0; i < features.size(); ++i) features[i] = i;
  return features;
}

TEST(FrameTracker, PointsOfAKeyframeThatIsNotInTheMapYetAreTracked) {
  TrackingBench bench(CameraKind::depth);
  // Half of the points are in the map; a new keyframe brings the rest, with their depths.
  ExactMap half(bench.world, CameraKind::depth, 0.1);
  half.add(0, at(0.0), {.from = 0, .to = 150});
  bench.tracker.set_view(view_of(half.graph, 0, {}));
  const Observed fresh = bench.observe(5, at(0.3), {.from = 150});
  bench.tracker.add_depth_points(5, fresh.frame, at(0.3), all_features(*fresh.frame));
  const Observed observed = bench.observe(7, near_keyframe());
  const TrackingResult result = bench.tracker.track_from(observed.frame, at(0.31));
  std::size_t of_fresh = 0;
  for (const TrackedPoint& point : result.points) {
    const std::uint32_t seen = observed.seen[point.feature];
    EXPECT_EQ(point.landmark < 0, seen >= 150);
    if (point.landmark >= 0) continue;
    ++of_fresh;
    EXPECT_EQ(point.keyframe, 5);
    EXPECT_EQ(fresh.seen[point.keyframe_feature], seen);
    EXPECT_LT((point.position - bench.world.points[seen]).norm(), 1e-3);
  }
  EXPECT_GT(of_fresh, 140U);
  // Once the map has that keyframe, its points are found as landmarks or not at all.
  half.add(5, at(0.3), {.from = 0, .to = 100});
  bench.tracker.set_view(view_of(half.graph, 5, {}));
  const std::vector<TrackedPoint> known = bench.tracker.track_from(observed.frame, at(0.31)).points;
  EXPECT_GT(known.size(), 100U);
  for (const TrackedPoint& point : known) EXPECT_GE(point.landmark, 0);
}

}  // namespace
}  // namespace rastro
