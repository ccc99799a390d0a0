// SPDX-License-Identifier: Apache-2.0
// What EKF-SLAM keeps of a drive: keyframes, constraints, frames, candidates.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rastro/map/graph/planar.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/slam/ekf/ekf_slam.h"

namespace rastro {
namespace {

constexpr double radians_per_degree = std::numbers::pi / 180.0;

struct Mark {
  std::int64_t id;
  double x, y;
};

/// A frame with exact odometry and exact observations of the landmarks.
Frame frame_from(std::int64_t index, const SE2& pose, const std::vector<Mark>& marks = {}) {
  Frame frame;
  frame.index = index;
  frame.stamp = 1'000'000'000 + index * 100'000'000;
  frame.odometry_from_body = pose;
  for (const Mark& mark : marks) {
    const Eigen::Vector2d seen = pose.inverse() * Eigen::Vector2d(mark.x, mark.y);
    frame.landmarks.push_back({mark.id, seen.norm(), std::atan2(seen.y(), seen.x())});
  }
  return frame;
}

SE2 ahead(double meters) { return {SO2(), {meters, 0.0}}; }

/// Drives along x at 0.1 m per frame.
void drive_ahead(EkfSlam& slam, int frames, const std::vector<Mark>& marks = {}, int first = 0) {
  for (int k = first; k < first + frames; ++k) slam.process(frame_from(k, ahead(0.1 * k), marks));
}

TEST(EkfMap, KeyframesHaveTheGivenSpacingInPositionOrYaw) {
  EkfOptions options;
  options.keyframe_m = 0.35, options.keyframe_deg = 20.0;
  EkfSlam straight(options, false), turning(options, false);
  drive_ahead(straight, 20);
  for (int k = 0; k < 20; ++k) turning.process(frame_from(k, SE2(SO2::from_angle(0.1 * k), {0.0, 0.0})));
  for (const EkfSlam* slam : {&straight, &turning}) {
    const auto map = slam->snapshot();
    ASSERT_EQ(map->keyframes.size(), 5U);
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_EQ(map->keyframes[k].frame, static_cast<std::int64_t>(4 * k)) << "0.4 m or 23 degrees";
      EXPECT_EQ(map->keyframes[k].id, static_cast<KeyframeId>(k));
      EXPECT_EQ(map->keyframes[k].parent, static_cast<KeyframeId>(k) - 1);
      EXPECT_EQ(map->keyframes[k].stamp, 1'000'000'000 + 400'000'000 * static_cast<TimeNs>(k));
    }
    EXPECT_EQ(contradiction_in(*map), "");
  }
}

TEST(EkfMap, ConstraintsHaveTheUncertaintyOfOdometryOverTheirPath) {
  EkfOptions options;
  options.keyframe_m = 0.35;
  EkfSlam slam(options, false);
  drive_ahead(slam, 10);
  const auto map = slam.snapshot();
  ASSERT_EQ(map->constraints.size(), 2U);
  const double position_variance = 0.02 * 0.02 * 0.4 + 1e-8,
               yaw_variance = std::pow(0.5 * radians_per_degree, 2) * 0.4 + 1e-8;
  for (std::size_t i = 0; i < 2; ++i) {
    const Constraint& constraint = map->constraints[i];
    EXPECT_EQ(constraint.from, static_cast<KeyframeId>(i));
    EXPECT_EQ(constraint.to, static_cast<KeyframeId>(i) + 1);
    EXPECT_EQ(constraint.kind, ConstraintKind::odometry);
    EXPECT_NEAR(constraint.from_from_to.translation().x(), 0.4, 1e-9);
    EXPECT_NEAR(constraint.information(0, 0), 1.0 / position_variance, 1e-3 / position_variance);
    EXPECT_NEAR(constraint.information(1, 1), 1.0 / position_variance, 1e-3 / position_variance);
    EXPECT_NEAR(constraint.information(5, 5), 1.0 / yaw_variance, 1e-3 / yaw_variance);
  }
}

TEST(EkfMap, EveryFrameHasTheFiltersPose) {
  EkfOptions options;
  options.keyframe_m = 0.35;
  EkfSlam slam(options, false);
  EXPECT_TRUE(slam.snapshot()->keyframes.empty());
  drive_ahead(slam, 11, {{3, 2.0, 1.0}});
  const auto map = slam.snapshot();
  const Trajectory found = trajectory_of(*map), expected = slam.trajectory();
  ASSERT_EQ(found.size(), 11U);
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].stamp, expected[k].stamp);
    EXPECT_LT((found[k].world_from_body.inverse() * expected[k].world_from_body).log().norm(), 1e-12);
    EXPECT_EQ(map->frames[k].keyframe, static_cast<KeyframeId>(k / 4));
  }
  EXPECT_EQ(map->revision, 11);
  EXPECT_EQ(map->method, "ekf");
  ASSERT_EQ(map->sessions.size(), 1U);
  EXPECT_EQ(map->sessions[0].first_stamp, expected.front().stamp);
  EXPECT_EQ(map->sessions[0].last_stamp, expected.back().stamp);
  EXPECT_TRUE(scale_of(*map).metric);
}

TEST(EkfMap, WithoutMappingThePoseIsTrackedAndNothingIsAdded) {
  EkfOptions options;
  options.observations = 2;
  EkfSlam slam(options, false);
  drive_ahead(slam, 3, {{3, 2.0, 1.0}});
  EXPECT_TRUE(slam.set_mapping(false));
  drive_ahead(slam, 30, {{3, 2.0, 1.0}, {4, 2.0, -1.0}}, 3);
  auto map = slam.snapshot();
  EXPECT_EQ(map->keyframes.size(), 1U);
  EXPECT_EQ(map->layer<LandmarkLayer>()->landmarks.size(), 1U);
  EXPECT_EQ(map->layer<LandmarkLayer>()->estimates[0].observations, 33) << "known ones are still updated";
  EXPECT_EQ(trajectory_of(*map).size(), 33U);
  slam.set_mapping(true);
  drive_ahead(slam, 3, {{3, 2.0, 1.0}, {4, 2.0, -1.0}}, 33);
  map = slam.snapshot();
  EXPECT_EQ(map->keyframes.size(), 2U);
  EXPECT_EQ(map->layer<LandmarkLayer>()->landmarks.size(), 2U);
}

TEST(EkfMap, ACandidateIsRemovedAfterTheGivenFrames) {
  EkfOptions options;
  options.candidate_frames = 3, options.observations = 4;
  EkfSlam slam(options, false);
  slam.process(frame_from(0, ahead(0.0), {{7, 2.0, 1.0}, {8, 2.0, -1.0}}));
  EXPECT_EQ(slam.filter().landmarks(), 2U);
  for (int k = 1; k <= 3; ++k) {
    drive_ahead(slam, 1, {{8, 2.0, -1.0}}, k);
    EXPECT_EQ(slam.filter().landmarks(), 2U) << k;
  }
  drive_ahead(slam, 1, {{8, 2.0, -1.0}}, 4);
  EXPECT_EQ(slam.filter().landmarks(), 1U) << "7, not observed since";
  drive_ahead(slam, 10, {}, 5);
  EXPECT_EQ(slam.filter().landmarks(), 1U) << "8 is a landmark now";
  const auto landmarks = slam.snapshot()->layer<LandmarkLayer>();
  ASSERT_EQ(landmarks->landmarks.size(), 1U);
  EXPECT_EQ(landmarks->estimates[0].sensor_id, 8);
  EXPECT_LT((landmarks->landmarks[0].position - Eigen::Vector3d(2.0, -1.0, 0.0)).norm(), 1e-6);
}

TEST(EkfMap, AFullMapTakesNoMoreLandmarksAndReportsIt) {
  EkfOptions options;
  options.max_landmarks = 2, options.observations = 1;
  EkfSlam slam(options, false);
  drive_ahead(slam, 1, {{7, 2.0, 1.0}});
  EXPECT_TRUE(slam.finish().empty());
  drive_ahead(slam, 1, {{7, 2.0, 1.0}, {8, 2.0, -1.0}, {9, 3.0, 0.0}}, 1);
  EXPECT_EQ(slam.filter().landmarks(), 2U);
  const auto events = slam.finish();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].kind, "landmark");
  EXPECT_NE(events[0].detail.find("max_landmarks=2"), std::string::npos);
}

TEST(EkfMap, ContradictionsAreReportedFromTwoOnAndIfTheyAreTheMajority) {
  const std::vector<Mark> marks = {{1, 2.0, 1.0}, {2, 3.0, -1.0}, {3, 4.0, 1.0}, {4, 3.0, 2.0}, {5, 5.0, 0.0}};
  for (std::size_t wrong = 0; wrong <= 5; ++wrong) {
    EkfSlam slam(EkfOptions(), false);
    drive_ahead(slam, 8, marks);
    std::vector<Mark> seen = marks;
    for (std::size_t i = 0; i < wrong; ++i) seen[i].y += 4.0;
    const SlamUpdate update = slam.process(frame_from(8, ahead(0.8), seen));
    EXPECT_EQ(update.used, 5 - static_cast<int>(wrong));
    EXPECT_DOUBLE_EQ(update.score, static_cast<double>(5 - wrong) / 5.0);
    EXPECT_EQ(update.reason, wrong >= 3 ? SlamReason::poor_match : SlamReason::none) << wrong;
  }
  EkfSlam slam(EkfOptions(), false);
  drive_ahead(slam, 8, {marks[0]});
  EXPECT_EQ(slam.process(frame_from(8, ahead(0.8), {{1, 2.0, 5.0}})).reason, SlamReason::none) << "a single one";
}

TEST(EkfMap, AScanNeedsTheMinimumOfReturns) {
  for (const int returns : {19, 20}) {
    EkfSlam slam(EkfOptions(), true);
    Frame frame = frame_from(0, SE2());
    frame.scan.emplace();
    frame.scan->angle_step = 0.01;
    frame.scan->max_range = 80.0;
    frame.scan->ranges.assign(180, 80.0F);
    std::fill_n(frame.scan->ranges.begin(), returns, 5.0F);
    EXPECT_EQ(slam.process(frame).reason == SlamReason::few_returns, returns == 19) << returns;
  }
}

TEST(GivenObservations, AreWithinTheRangeWithTheirNoiseAlongAndAcross) {
  const EkfOptions options;
  Frame frame;
  frame.landmarks = {{1, 200.0, 0.0}, {2, 200.1, 0.0}, {3, 0.0, 0.0}, {4, -1.0, 0.0}, {5, 4.0, std::numbers::pi / 2.0}};
  const std::vector<BodyObservation> observations = given_observations(frame.landmarks, options);
  ASSERT_EQ(observations.size(), 2U);
  EXPECT_EQ(observations[0].sensor_id, 1);
  EXPECT_EQ(observations[1].sensor_id, 5);
  EXPECT_LT((observations[1].in_body - Eigen::Vector2d(0.0, 4.0)).norm(), 1e-12);
  const double along = 0.05 + 0.01 * 4.0, across = 4.0 * radians_per_degree, least = 1e-3 * 0.05;
  EXPECT_NEAR(observations[1].covariance(1, 1), along * along, 1e-12);
  EXPECT_NEAR(observations[1].covariance(0, 0), across * across + least * least, 1e-12);
  EXPECT_NEAR(observations[1].covariance(0, 1), 0.0, 1e-12);
}

}  // namespace
}  // namespace rastro
