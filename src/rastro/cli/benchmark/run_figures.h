// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "rastro/cli/benchmark/run_frames.h"
#include "rastro/evaluate/trajectory_scores.h"

namespace rastro::cli {

/// Figures of a run by name, each with its unit in the name; what could not be measured is missing.
using RunFigures = std::map<std::string, double>;

/// After alignment: ate_m (rmse), ate_max_m, rpe_frame_m, rpe_frame_deg, rpe_second_m, rpe_second_deg (rmse),
/// drift_percent, coverage_percent. Of lengths: scale_error_percent (only where `claims_meters`: lengths of the
/// estimate over true ones, minus 1) and scale_drift_percent (scale of the second half of the poses over that of the
/// first, minus 1). Of fewer than three matched poses only coverage_percent: an alignment makes any two fit.
void add_trajectory_figures(const TrajectoryScores& scores, const TrajectoryInput& reference, bool claims_meters,
                            RunFigures& figures);

/// Of result.json: frame_ms, frame_p95_ms, frames_per_second, map_mb, loops, and stage/NAME_ms for each stage, per
/// frame of the run.
void add_result_figures(const nlohmann::ordered_json& result, RunFigures& figures);

/// Of the frames: start_s (from the first frame to the first tracked one), losses (times that tracking was lost after
/// that) and longest_loss_s (until the next tracked frame, or the end).
void add_frame_figures(const std::vector<RunFrame>& frames, RunFigures& figures);

/// The first frame that is not tracked after one that was, "frame 12: few_points"; empty: there is none.
std::string first_loss_of(const std::vector<RunFrame>& frames);

}  // namespace rastro::cli
