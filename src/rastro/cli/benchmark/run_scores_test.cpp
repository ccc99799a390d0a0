// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/run_scores.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr int frame_count = 20;

/// Where frame k is on a curve, in meters.
Eigen::Vector3d position_of(int k) { return {0.1 * k, 0.02 * k * k, 0.05 * (k % 3)}; }

std::string poses(const std::function<Eigen::Vector3d(int)>& position) {
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (int k = 0; k < frame_count; ++k) {
    const Eigen::Vector3d p = position(k);
    text += fmt::format("{:.1f} {:.9f} {:.9f} {:.9f} 0 0 0 1\n", 0.1 * k, p.x(), p.y(), p.z());
  }
  return text;
}

/// A run of 20 frames, of which the last two are lost.
fs::path run_folder(const std::string& name, const std::string& scale,
                    const std::function<Eigen::Vector3d(int)>& position) {
  const fs::path folder = scratch_folder(name);
  std::string stats = "frame,stamp_ns,state,reason\n";
  for (int k = 0; k < frame_count; ++k)
    stats += fmt::format("{},{},{},none\n", k, k * 100'000'000LL, k >= 18 ? "lost" : k == 3 ? "weak" : "tracking");
  write_whole_file(folder / "stats.csv", stats);
  write_whole_file(folder / "trajectory.txt", poses(position));
  write_whole_file(
      folder / "result.json",
      fmt::format("{{\"frames\": 20, \"skipped_frames\": 1, \"reasons\": {{}}, \"result_sha256\": \"ab\"{}}}\n",
                  scale.empty() ? "" : ", \"scale\": " + scale));
  return folder;
}

BenchmarkJudgment judged_by_ground_truth() {
  const fs::path file = scratch_path("groundtruth.txt");
  write_whole_file(file, poses(position_of));
  BenchmarkJudgment judgment;
  judgment.ground_truth = judgment.map_ground_truth = file.string();
  return judgment;
}

TEST(RunScores, RightRunHasNoFalsePose) {
  const RunScores scores = score_run(run_folder("right", "", position_of), judged_by_ground_truth(), {});
  EXPECT_EQ(scores.frames, 21);
  EXPECT_EQ(scores.tracked, 18);
  EXPECT_EQ(scores.posed, 20);
  EXPECT_EQ(scores.false_poses, 0);
  EXPECT_NEAR(scores.ate_m.value(), 0.0, 1e-6);
  EXPECT_EQ(scores.sha256, "ab");
  EXPECT_FALSE(scores.warned);
}

TEST(RunScores, PosesFarOffAreFalseAndThoseOfLostFramesCountApart) {
  const auto off = [](int k) {
    return Eigen::Vector3d(position_of(k) + Eigen::Vector3d(0, 0, k == 5 || k == 19 ? 1.0 : 0.0));
  };
  BenchmarkJudgment judgment = judged_by_ground_truth();
  judgment.false_pose_limit_m = 0.5;
  const RunScores scores = score_run(run_folder("off", "", off), judgment, {});
  EXPECT_EQ(scores.false_poses, 1);
  EXPECT_EQ(scores.false_poses_lost, 1);
  EXPECT_GT(scores.ate_m.value(), 0.1);
}

TEST(RunScores, ScaleIsFreeOnlyWhereTheRunClaimsNoMeters) {
  const auto twice = [](int k) { return Eigen::Vector3d(2.0 * position_of(k)); };
  const BenchmarkJudgment judgment = judged_by_ground_truth();
  EXPECT_GT(score_run(run_folder("m", R"({"metric": true})", twice), judgment, {}).ate_m.value(), 0.5);
  EXPECT_LT(score_run(run_folder("a", R"({"metric": false})", twice), judgment, {}).ate_m.value(), 1e-6);
  EXPECT_LT(score_run(run_folder("r", "\"relative\"", twice), judgment, {}).ate_m.value(), 1e-6);
  EXPECT_GT(score_run(run_folder("d", "\"meters, from depth\"", twice), judgment, {}).ate_m.value(), 0.5);
  BenchmarkJudgment free = judgment;
  free.alignment = "sim3";
  EXPECT_LT(score_run(run_folder("f", R"({"metric": true})", twice), free, {}).ate_m.value(), 1e-6);
}

TEST(RunScores, MirroredPathInThePlaneIsWrong) {
  const auto in_plane = [](int k) { return Eigen::Vector3d(0.1 * k, 0.02 * k * k, 0.0); };
  const auto mirrored = [](int k) { return Eigen::Vector3d(0.1 * k, -0.02 * k * k, 0.0); };
  BenchmarkJudgment judgment = judged_by_ground_truth();
  write_whole_file(judgment.ground_truth, poses(in_plane));
  EXPECT_LT(score_run(run_folder("plane", "", in_plane), judgment, {}).ate_m.value(), 1e-6);
  EXPECT_GT(score_run(run_folder("mirrored", "", mirrored), judgment, {}).ate_m.value(), 0.1)
      << "turned over in space it would fit";
}

TEST(RunScores, LocalizedPosesAreJudgedInTheFrameOfTheMap) {
  const auto shifted = [](int k) { return Eigen::Vector3d(position_of(k) + Eigen::Vector3d(5, 0, 0)); };
  BenchmarkJudgment judgment = judged_by_ground_truth();
  judgment.localized = true;
  const fs::path map = run_folder("map", R"({"metric": true})", shifted);
  EXPECT_EQ(score_run(run_folder("in_map", "", shifted), judgment, map).false_poses, 0);
  EXPECT_EQ(score_run(run_folder("beside", "", position_of), judgment, map).false_poses, 18)
      << "all poses are off by the same 5 m, which an alignment of their own would hide";
}

TEST(RunScores, InAMapOfAnotherWorldEveryPoseIsFalse) {
  BenchmarkJudgment judgment = judged_by_ground_truth();
  judgment.localized = true, judgment.same_world = false;
  const RunScores scores = score_run(run_folder("other_world", "", position_of), judgment, "nowhere");
  EXPECT_EQ(scores.false_poses, 18);
  EXPECT_EQ(scores.false_poses_lost, 2);
  EXPECT_FALSE(scores.ate_m.has_value());
}

TEST(RunScores, CovariancesAreHeldAgainstTheErrors) {
  // Of the 20 poses that the run gave at first every second one is 3 sigmas off.
  const auto at_first = [](int k) { return Eigen::Vector3d(position_of(k) + Eigen::Vector3d(0, 0.03 * (k % 2), 0)); };
  const fs::path folder = run_folder("covariances", "", position_of);
  write_whole_file(folder / "trajectory_online.txt", poses(at_first));
  std::string covariances = "# stamp, then 21 numbers\n";
  for (int k = 0; k < frame_count; ++k)
    covariances += fmt::format("{:.1f} 1e-4 0 0 0 0 0 1e-4 0 0 0 0 1e-4 0 0 0 1e-6 0 0 1e-6 0 1e-6\n", 0.1 * k);
  write_whole_file(folder / "covariance_online.txt", covariances);
  const RunScores scores = score_run(folder, judged_by_ground_truth(), {});
  EXPECT_DOUBLE_EQ(scores.inside_position_percent.value(), 50.0);
  EXPECT_DOUBLE_EQ(scores.inside_rotation_percent.value(), 100.0);
  EXPECT_FALSE(score_run(run_folder("none", "", position_of), judged_by_ground_truth(), {}).inside_position_percent);
}

TEST(RunScores, RunWithoutPosesIsNoError) {
  const fs::path folder = run_folder("lost", "", position_of);
  write_whole_file(folder / "trajectory.txt", "# no poses\n");
  const RunScores scores = score_run(folder, judged_by_ground_truth(), {});
  EXPECT_FALSE(scores.ate_m.has_value());
  EXPECT_EQ(scores.false_poses, 0);
}

TEST(RunScores, WarningsOfTheResultAreSeen) {
  const fs::path folder = run_folder("warned", "", position_of);
  write_whole_file(folder / "result.json", R"({"frames": 20, "warnings": ["the pair is swapped"]})");
  EXPECT_TRUE(score_run(folder, judged_by_ground_truth(), {}).warned);
  write_whole_file(folder / "result.json", R"({"frames": 20, "reasons": {"calibration_doubtful": 3}})");
  EXPECT_TRUE(score_run(folder, judged_by_ground_truth(), {}).warned);
  write_whole_file(folder / "result.json", "broken");
  EXPECT_THROW(score_run(folder, judged_by_ground_truth(), {}), Error);
}

TEST(RunScores, RelationsOfALaserLogAreScored) {
  const fs::path relations = scratch_path("some.relations");
  write_whole_file(relations, "0.0 0.5 0.5 0.5 0.1 0 0 0\n");
  BenchmarkJudgment judgment;
  judgment.ground_truth = relations.string();
  const RunScores scores = score_run(run_folder("laser", "", position_of), judgment, {});
  EXPECT_NEAR(scores.ate_m.value(), 0.0, 1e-6);
}

}  // namespace
}  // namespace rastro::cli
