// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/command.h"
#include "rastro/cli/evaluate_tracks.h"

namespace rastro::cli {

void add_evaluate_command(CLI::App& app, Context& context) {
  CLI::App* command =
      app.add_subcommand("evaluate", "Score a run against truth: how many ids came back, and how many wrongly");
  command->require_subcommand(1);
  command->footer(
      "Example:\n  rastro evaluate tracks run --truth hall\n`rastro evaluate tracks --help` describes every figure.");
  add_evaluate_tracks_command(*command, context);
}

}  // namespace rastro::cli
