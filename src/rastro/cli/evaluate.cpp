// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/command.h"
#include "rastro/cli/evaluate_cloud.h"
#include "rastro/cli/evaluate_loops.h"
#include "rastro/cli/evaluate_map.h"
#include "rastro/cli/evaluate_relations.h"
#include "rastro/cli/evaluate_tracks.h"
#include "rastro/cli/evaluate_trajectory.h"

namespace rastro::cli {

void add_evaluate_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("evaluate", "Evaluates tracks, trajectories and maps against ground truth");
  command->require_subcommand(1);
  command->footer(
      "Examples:\n  rastro evaluate tracks run --ground-truth hall\n  rastro evaluate trajectory groundtruth.txt run "
      "--align "
      "sim3\n  rastro evaluate relations run --relations intel.relations\n  rastro evaluate map run "
      "corridor/floor_plan.yaml\n  rastro evaluate cloud bedroom/truth.ply run\n  "
      "rastro evaluate loops run campus\n`rastro evaluate trajectory --help` "
      "etc. define every metric.");
  add_evaluate_tracks_command(*command, context);
  add_evaluate_trajectory_command(*command, context);
  add_evaluate_relations_command(*command, context);
  add_evaluate_map_command(*command, context);
  add_evaluate_cloud_command(*command, context);
  add_evaluate_loops_command(*command, context);
}

}  // namespace rastro::cli
