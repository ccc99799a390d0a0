// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_scores.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/evaluate/trajectory_report.h"

namespace rastro {
namespace {

using testing::HasSubstr;

/// A winding path of 100 poses at 10 Hz.
Trajectory winding() {
  Trajectory trajectory;
  for (int k = 0; k < 100; ++k) {
    const double t = 0.1 * k;
    trajectory.push_back({TimeNs(k) * 100'000'000, SE3(SO3::exp({0.1 * std::sin(t), 0.2 * std::cos(t), t}),
                                                       {5 * std::sin(t), 4 * std::cos(0.7 * t), 0.5 * t})});
  }
  return trajectory;
}

/// An estimate that `reference_from_estimate` aligns with the reference.
Trajectory seen_through(const Trajectory& reference, const Sim3& reference_from_estimate) {
  const Sim3 back = reference_from_estimate.inverse();
  Trajectory estimate;
  for (const StampedPose& pose : reference)
    estimate.push_back({pose.stamp, SE3(back.rotation() * pose.world_from_body.rotation(),
                                        back * pose.world_from_body.translation())});
  return estimate;
}

TrajectoryScores score(const Trajectory& reference, const Trajectory& estimate, TrajectoryAlignment alignment) {
  TrajectoryScoreOptions options;
  options.alignment = alignment;
  options.segments_m = {10, 20};
  return score_trajectory(trajectory_input_from(reference, "ref"), trajectory_input_from(estimate, "est"), options);
}

template <typename Run>
std::string error_of(Run run) {
  try {
    run();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

void expect_perfect(const TrajectoryScores& scores) {
  EXPECT_NEAR(scores.ate_m->max, 0.0, 1e-9);
  for (const RpeScores& rpe : scores.rpe) {
    EXPECT_NEAR(rpe.translation_m->max, 0.0, 1e-9);
    EXPECT_NEAR(rpe.rotation_deg->max, 0.0, 1e-6);
  }
  EXPECT_NEAR(*scores.t_rel_percent, 0.0, 1e-7);
  EXPECT_NEAR(*scores.drift_percent, 0.0, 1e-7);
}

TEST(TrajectoryScores, AlignmentsRemoveTheTransformOfTheirKind) {
  const Trajectory reference = winding();
  expect_perfect(score(reference, reference, TrajectoryAlignment::none));
  const Sim3 rigid(1.0, SO3::exp({0.5, -1.0, 2.0}), {10, 20, -3});
  expect_perfect(score(reference, seen_through(reference, rigid), TrajectoryAlignment::se3));
  const Sim3 yaw(1.0, SO3::exp({0, 0, 2.5}), {10, 20, -3});
  expect_perfect(score(reference, seen_through(reference, yaw), TrajectoryAlignment::yaw));
  const Sim3 similar(2.5, SO3::exp({0.5, -1.0, 2.0}), {10, 20, -3});
  const auto scores = score(reference, seen_through(reference, similar), TrajectoryAlignment::sim3);
  expect_perfect(scores);
  EXPECT_NEAR(scores.scale(), 2.5, 1e-12);
  EXPECT_NEAR(scores.estimate_path_m, scores.reference_path_m, 1e-9);
}

TEST(TrajectoryScores, OriginLetsErrorsGrowFromTheFirstPose) {
  const Trajectory reference = winding();
  const Sim3 rigid(1.0, SO3::exp({0.5, -1.0, 2.0}), {10, 20, -3});
  expect_perfect(score(reference, seen_through(reference, rigid), TrajectoryAlignment::origin));
  Trajectory turned = reference;
  for (std::size_t k = 60; k < turned.size(); ++k)
    turned[k].world_from_body = turned[k].world_from_body * SE3(SO3(), {0.0, 3.0, 0.0});
  const auto scores = score(reference, turned, TrajectoryAlignment::origin);
  EXPECT_NEAR(scores.ate_m->max, 3.0, 1e-9);
  EXPECT_NEAR(scores.ate_m->median, 0.0, 1e-9);
}

TEST(TrajectoryScores, AlignmentsRemoveNothingElse) {
  const Trajectory reference = winding();
  const Sim3 offset(1.0, SO3(), {3, 4, 0});
  EXPECT_NEAR(score(reference, seen_through(reference, offset), TrajectoryAlignment::none).ate_m->rmse, 5.0, 1e-9);
  const Sim3 tilted(1.0, SO3::exp({0.3, 0, 0}), {0, 0, 0});
  EXPECT_GT(score(reference, seen_through(reference, tilted), TrajectoryAlignment::yaw).ate_m->rmse, 0.3);
  const Sim3 scaled(2.0, SO3(), {0, 0, 0});
  const auto rigid = score(reference, seen_through(reference, scaled), TrajectoryAlignment::se3);
  EXPECT_GT(rigid.ate_m->rmse, 1.0);
  EXPECT_EQ(rigid.scale(), 1.0);
  EXPECT_NEAR(rigid.estimate_path_m, 0.5 * rigid.reference_path_m, 1e-9);
}

TEST(TrajectoryScores, DriftIsPerLengthOfThePath) {
  Trajectory reference, estimate;
  for (int k = 0; k <= 50; ++k) {
    reference.push_back({TimeNs(k) * 100'000'000, SE3(SO3(), {1.0 * k, 0, 0})});
    estimate.push_back({TimeNs(k) * 100'000'000, SE3(SO3::exp({0, 0, 0.002 * k}), {1.0 * k, 0.02 * k, 0})});
  }
  const auto scores = score(reference, estimate, TrajectoryAlignment::none);
  EXPECT_NEAR(*scores.drift_percent, 2.0, 1e-9);
  EXPECT_NEAR(*scores.drift_deg_per_m, 0.1 * 57.29577951308232 / 50.0, 1e-9);
  EXPECT_NEAR(scores.reference_path_m, 50.0, 1e-9);
}

TEST(TrajectoryScores, OneMatchedPoseGivesPartialScores) {
  const Trajectory reference = winding();
  const auto scores = score(reference, {reference[7]}, TrajectoryAlignment::se3);
  EXPECT_EQ(scores.pairing.matched, 1);
  EXPECT_FALSE(scores.alignment_unique);
  EXPECT_FALSE(scores.rpe.front().translation_m);
  EXPECT_FALSE(scores.t_rel_percent);
  EXPECT_FALSE(scores.drift_percent);
  EXPECT_THAT(trajectory_scores_as_json({scores}), HasSubstr("\"rpe_trans_rmse\": null"));
}

TEST(TrajectoryScores, InputThatCannotBeScoredIsAnError) {
  const Trajectory reference = winding();
  Trajectory late = reference, still = reference;
  for (StampedPose& pose : late) pose.stamp += 1000 * ns_per_second;
  for (StampedPose& pose : still) pose.world_from_body = SE3();
  EXPECT_THAT(error_of([&] { score(reference, late, TrajectoryAlignment::se3); }),
              HasSubstr("no pose is within 0.02 s"));
  EXPECT_THAT(error_of([&] { score(reference, still, TrajectoryAlignment::sim3); }), HasSubstr("does not move"));
  EXPECT_NO_THROW(score(reference, still, TrajectoryAlignment::se3));
  TrajectoryInput lines = trajectory_input_from(reference, "lines");
  lines.format = TrajectoryFormat::kitti;
  lines.has_stamps = false;
  EXPECT_THAT(error_of([&] { score_trajectory(trajectory_input_from(reference, "ref"), lines, {}); }),
              HasSubstr("times.txt"));
}

TEST(TrajectoryScores, KittiFilesOfOtherLengthsAreMatchedByStampWhereBothHaveThem) {
  const Trajectory reference = winding();
  TrajectoryInput whole = trajectory_input_from(reference, "whole");
  TrajectoryInput part = trajectory_input_from(Trajectory(reference.begin() + 20, reference.end()), "part");
  whole.format = part.format = TrajectoryFormat::kitti;
  const auto by_stamp = score_trajectory(whole, part, {});
  EXPECT_FALSE(by_stamp.pairing.by_index);
  EXPECT_LT(by_stamp.ate_m->max, 1e-9);
  part.has_stamps = false;
  const auto by_line = score_trajectory(whole, part, {});
  EXPECT_TRUE(by_line.pairing.by_index);
  EXPECT_GT(by_line.ate_m->max, 0.01);
}

TEST(TrajectoryReport, JsonHasEveryFigure) {
  const Trajectory reference = winding();
  const auto scores = score(reference, reference, TrajectoryAlignment::sim3);
  const std::string json = trajectory_scores_as_json({scores});
  for (const char* name : {"matched", "coverage", "alignment", "scale", "ate_rmse", "ate_mean", "ate_median", "ate_max",
                           "rpe_trans_rmse", "rpe_rot_rmse_deg", "t_rel_percent", "r_rel_deg_per_m"})
    EXPECT_THAT(json, HasSubstr("\n  \"" + std::string(name) + "\": ")) << name;
  EXPECT_EQ(json.front(), '{');
  EXPECT_EQ(trajectory_scores_as_json({scores, scores}).front(), '[');
}

TEST(TrajectoryReport, TableReportsDifferentCoverage) {
  const Trajectory reference = winding();
  const auto whole = score(reference, reference, TrajectoryAlignment::se3);
  const auto half = score(reference, Trajectory(reference.begin(), reference.begin() + 50), TrajectoryAlignment::se3);
  EXPECT_EQ(half.pairing.coverage_percent, 50.0);
  EXPECT_THAT(trajectory_scores_as_table({whole, half}), HasSubstr("coverage differs (50.0 to 100.0 %)"));
  EXPECT_THAT(trajectory_scores_as_table({whole, whole}), testing::Not(HasSubstr("coverage differs")));
}

TEST(TrajectoryReport, LimitsAreChecked) {
  const Trajectory reference = winding();
  const auto scores = score(reference, reference, TrajectoryAlignment::se3);
  EXPECT_TRUE(keeps_limit(trajectory_score_named(scores, "ate_rmse"), parse_trajectory_limit("ate_rmse<=0.3")));
  EXPECT_FALSE(keeps_limit(trajectory_score_named(scores, "coverage"), parse_trajectory_limit("coverage>=101")));
  EXPECT_THAT(error_of([] { parse_trajectory_limit("ate_rms<=1"); }), HasSubstr("'ate_rmse'"));
  EXPECT_THAT(error_of([] { parse_trajectory_limit("ate_rmse=1"); }), HasSubstr("is not a limit"));
}

}  // namespace
}  // namespace rastro
