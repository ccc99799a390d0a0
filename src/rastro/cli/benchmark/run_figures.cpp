// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/run_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "rastro/math/alignment.h"

namespace rastro::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t fewest_poses = 3;  ///< Any two fit after an alignment, however wrong they are.

/// Reference lengths per length of the estimate, over pairs [first, end).
std::optional<double> scale_between(const TrajectoryScores& scores, const TrajectoryInput& reference, std::size_t first,
                                    std::size_t end) {
  std::vector<Eigen::Vector3d> target, source;
  for (std::size_t k = first; k < end; ++k) {
    target.push_back(reference.poses[scores.pairs[k].reference].world_from_body.translation());
    source.push_back(scores.aligned[k].world_from_body.translation());
  }
  const auto alignment = align_points(target, source, AlignmentKind::similarity);
  if (!alignment || !(alignment->target_from_source.scale() > 0.0)) return std::nullopt;
  return alignment->target_from_source.scale();
}

void add_scale_figures(const TrajectoryScores& scores, const TrajectoryInput& reference, bool claims_meters,
                       RunFigures& figures) {
  constexpr double shortest_path_m = 0.2;  // a camera at rest has no scale
  if (scores.reference_path_m < shortest_path_m) return;
  const std::size_t count = scores.pairs.size();
  const auto whole = scale_between(scores, reference, 0, count);
  if (claims_meters && whole && count >= fewest_poses) figures["scale_error_percent"] = 100.0 * (1.0 / *whole - 1.0);
  if (count < 2 * fewest_poses) return;
  const auto first = scale_between(scores, reference, 0, count / 2);
  const auto second = scale_between(scores, reference, count / 2, count);
  if (first && second) figures["scale_drift_percent"] = 100.0 * (*second / *first - 1.0);
}

void add_number(const Json& result, const char* key, const char* name, RunFigures& figures) {
  const auto found = result.find(key);
  if (found != result.end() && found->is_number()) figures[name] = found->get<double>();
}

bool is_not_yet(const RunFrame& frame) { return !frame.tracked; }
bool is_tracked(const RunFrame& frame) { return frame.tracked; }

}  // namespace

void add_trajectory_figures(const TrajectoryScores& scores, const TrajectoryInput& reference, bool claims_meters,
                            RunFigures& figures) {
  figures["coverage_percent"] = scores.pairing.coverage_percent;
  if (scores.pairs.size() < fewest_poses) return;
  if (scores.ate_m) figures["ate_m"] = scores.ate_m->rmse, figures["ate_max_m"] = scores.ate_m->max;
  if (scores.drift_percent) figures["drift_percent"] = *scores.drift_percent;
  for (const RpeScores& rpe : scores.rpe) {
    if (rpe.delta.unit == RpeDelta::Unit::meters) continue;
    const std::string name = rpe.delta.unit == RpeDelta::Unit::frames ? "rpe_frame" : "rpe_second";
    if (rpe.translation_m) figures[name + "_m"] = rpe.translation_m->rmse;
    if (rpe.rotation_deg) figures[name + "_deg"] = rpe.rotation_deg->rmse;
  }
  add_scale_figures(scores, reference, claims_meters, figures);
}

void add_result_figures(const Json& result, RunFigures& figures) {
  add_number(result, "ms_per_frame_mean", "frame_ms", figures);
  add_number(result, "ms_per_frame_p95", "frame_p95_ms", figures);
  add_number(result, "map_memory_mb", "map_mb", figures);
  add_number(result, "loops_closed", "loops", figures);
  if (const auto frame_ms = figures.find("frame_ms"); frame_ms != figures.end() && frame_ms->second > 0.0)
    figures["frames_per_second"] = 1e3 / frame_ms->second;
  const double frames = result.value("frames", 0.0);
  const auto stages = result.find("stages");
  if (stages == result.end() || !stages->is_object() || frames < 1.0) return;
  for (const auto& [name, stage] : stages->items())
    figures["stage/" + name + "_ms"] = stage.value("ms_mean", 0.0) * stage.value("frames", 0.0) / frames;
}

void add_frame_figures(const std::vector<RunFrame>& frames, RunFigures& figures) {
  const auto start = std::find_if(frames.begin(), frames.end(), is_tracked);
  if (start == frames.end()) return;
  figures["start_s"] = to_seconds(start->stamp - frames.front().stamp);
  double losses = 0.0, longest_s = 0.0;
  for (auto lost = start; (lost = std::find_if(lost, frames.end(), is_not_yet)) != frames.end();) {
    const auto again = std::find_if(lost, frames.end(), is_tracked);
    const TimeNs end = again == frames.end() ? frames.back().stamp : again->stamp;
    longest_s = std::max(longest_s, to_seconds(end - std::prev(lost)->stamp));
    losses += 1.0;
    lost = again;
  }
  figures["losses"] = losses, figures["longest_loss_s"] = longest_s;
}

std::string first_loss_of(const std::vector<RunFrame>& frames) {
  const auto start = std::find_if(frames.begin(), frames.end(), is_tracked);
  const auto lost = std::find_if(start, frames.end(), is_not_yet);
  return lost == frames.end() ? "" : fmt::format("frame {}: {}", lost->frame, lost->reason);
}

}  // namespace rastro::cli
