// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/run_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/text_file.h"
#include "rastro/cli/benchmark/run_figures.h"
#include "rastro/cli/benchmark/run_frames.h"
#include "rastro/cli/trajectory_files.h"
#include "rastro/evaluate/relations.h"
#include "rastro/evaluate/trajectory_pairs.h"
#include "rastro/evaluate/trajectory_scores.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr TimeNs pair_within = 20'000'000;  ///< As 'rastro evaluate trajectory'.
constexpr int fewest_pairs = 3;             ///< Fewer have no alignment.

Json result_of(const fs::path& folder) {
  const fs::path file = folder / "result.json";
  try {
    return Json::parse(read_whole_file(file));
  } catch (const Json::exception&) {
    throw Error("is not a result", file.string(), "run it again");
  }
}

/// Whether the lengths of the run are in meters, by its own words.
bool claims_meters(const Json& result) {
  const auto scale = result.find("scale");
  if (scale == result.end()) return true;
  if (scale->is_object()) return scale->value("metric", false);
  return scale->is_string() && scale->get<std::string>().starts_with("meters");
}

bool says_a_warning(const Json& result) {
  const auto warnings = result.find("warnings");
  if (warnings != result.end() && !warnings->empty()) return true;
  const auto reasons = result.find("reasons");
  return reasons != result.end() && reasons->contains("calibration_doubtful");
}

bool is_relations(const std::string& ground_truth) { return fs::path(ground_truth).extension() == ".relations"; }

/// A run beside its ground truth.
struct Compared {
  ReferenceTrajectory reference;
  TrajectoryInput estimate;
};

Compared compared(const fs::path& folder, const std::string& ground_truth) {
  Compared both;
  both.reference = read_reference(poses_beside(ground_truth), {});
  both.estimate = read_estimate(folder.string(), both.reference, {});
  return both;
}

/// A mirrored trajectory in a plane would be turned over by a rotation in space: it is aligned in its plane.
bool is_planar(const Trajectory& trajectory) {
  return std::all_of(trajectory.begin(), trajectory.end(),
                     [](const StampedPose& pose) { return pose.world_from_body.translation().z() == 0.0; });
}

std::string alignment_of(const Compared& both, const Json& result) {
  if (is_planar(both.estimate.poses)) return "yaw";
  return claims_meters(result) ? "se3" : "sim3";
}

TrajectoryScores aligned(const Compared& both, const std::string& alignment, const Json& result) {
  TrajectoryScoreOptions options;
  options.max_difference = pair_within;
  options.alignment = parse_alignment(alignment.empty() ? alignment_of(both, result) : alignment);
  return score_trajectory(both.reference.input, both.estimate, options);
}

/// Poses of a run in the frame of the ground truth, against it.
void judge_poses(const Compared& both, const Sim3& reference_from_estimate, const std::vector<PosePair>& pairs,
                 const std::vector<RunFrame>& frames, double limit_m, RunScores& scores) {
  double sum = 0.0;
  for (const PosePair& pair : pairs) {
    const StampedPose& pose = both.estimate.poses[pair.estimate];
    const Eigen::Vector3d& ground_truth = both.reference.input.poses[pair.reference].world_from_body.translation();
    const double off_m = (reference_from_estimate * pose.world_from_body.translation() - ground_truth).norm();
    sum += off_m * off_m;
    if (off_m > limit_m) ++(was_tracked(frames, pose.stamp) ? scores.false_poses : scores.false_poses_lost);
  }
  if (static_cast<int>(pairs.size()) >= fewest_pairs) scores.ate_m = std::sqrt(sum / static_cast<double>(pairs.size()));
}

std::int64_t count_poses(const fs::path& folder) {
  return static_cast<std::int64_t>(content_lines(read_text_file((folder / "trajectory.txt").string())).size());
}

void judge_run(const fs::path& folder, const BenchmarkJudgment& judgment, const Json& result,
               const std::vector<RunFrame>& frames, RunScores& scores) {
  const Compared both = compared(folder, judgment.ground_truth);
  if (static_cast<int>(both.estimate.poses.size()) < fewest_pairs) return;
  const TrajectoryScores found = aligned(both, judgment.alignment, result);
  judge_poses(both, found.reference_from_estimate, found.pairs, frames, judgment.false_pose_limit_m, scores);
  scores.alignment = name_of(found.alignment);
  add_trajectory_figures(found, both.reference.input, claims_meters(result), scores.figures);
  if (static_cast<int>(found.pairs.size()) < fewest_pairs) return;
  const PoseConsistency consistency =
      consistency_of_run(folder.string(), both.reference, both.estimate, found.scale(), pair_within);
  if (consistency.position) scores.inside_position_percent = consistency.position->inside_percent;
  if (consistency.rotation) scores.inside_rotation_percent = consistency.rotation->inside_percent;
}

void judge_relations(const fs::path& folder, const std::string& relations, RunScores& scores) {
  const TrajectoryInput estimate = read_trajectory_input((folder / "trajectory.txt").string());
  const RelationScores found =
      score_relations(parse_relations(read_text_file(relations), relations), estimate.poses, pair_within);
  if (found.relations > 0) scores.ate_m = found.trans_mean_m;
}

/// In the frame of the map, which the run that made it ties to the ground truth.
void judge_localized(const fs::path& folder, const BenchmarkJudgment& judgment, const fs::path& map_folder,
                     const std::vector<RunFrame>& frames, RunScores& scores) {
  if (!judgment.same_world) {
    const TrajectoryInput estimate = read_trajectory_input((folder / "trajectory.txt").string());
    for (const StampedPose& pose : estimate.poses)
      ++(was_tracked(frames, pose.stamp) ? scores.false_poses : scores.false_poses_lost);
    return;
  }
  const TrajectoryScores map =
      aligned(compared(map_folder, judgment.map_ground_truth), judgment.alignment, result_of(map_folder));
  const Compared both = compared(folder, judgment.ground_truth);
  const auto pairs = pair_by_stamp(both.reference.input.poses, both.estimate.poses, pair_within);
  judge_poses(both, map.reference_from_estimate, pairs, frames, judgment.false_pose_limit_m, scores);
}

void judge(const fs::path& folder, const BenchmarkJudgment& judgment, const fs::path& map_folder, const Json& result,
           const std::vector<RunFrame>& frames, RunScores& scores) {
  if (judgment.localized)
    judge_localized(folder, judgment, map_folder, frames, scores);
  else if (is_relations(judgment.ground_truth))
    judge_relations(folder, judgment.ground_truth, scores);
  else
    judge_run(folder, judgment, result, frames, scores);
}

}  // namespace

std::string poses_beside(const std::string& path) {
  const fs::path beside = fs::path(path) / "groundtruth.txt";
  std::error_code ignored;
  return fs::exists(fs::path(path) / "scans.log", ignored) && fs::exists(beside, ignored) ? beside.string() : path;
}

RunScores score_run(const fs::path& folder, const BenchmarkJudgment& judgment, const fs::path& map_folder) {
  const Json result = result_of(folder);
  const std::vector<RunFrame> frames = read_run_frames(folder / "stats.csv");
  RunScores scores;
  scores.frames = result.value("frames", std::int64_t{0}) + result.value("skipped_frames", std::int64_t{0});
  for (const RunFrame& frame : frames) scores.tracked += frame.tracked ? 1 : 0;
  scores.first_loss = first_loss_of(frames);
  add_result_figures(result, scores.figures);
  add_frame_figures(frames, scores.figures);
  scores.warned = says_a_warning(result);
  scores.sha256 = result.value("result_sha256", std::string());
  scores.posed = count_poses(folder);
  if (scores.posed > 0 && !judgment.ground_truth.empty()) judge(folder, judgment, map_folder, result, frames, scores);
  std::erase_if(scores.figures, [](const auto& figure) { return !std::isfinite(figure.second); });
  return scores;
}

}  // namespace rastro::cli
