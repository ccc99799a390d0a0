// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "rastro/cli/command.h"
#include "rastro/cli/slam.h"

namespace rastro::cli {

void add_localize_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("localize", "Localizes a recording in a map made before");
  const auto flags = std::make_shared<SlamFlags>();
  add_localize_flags(*command, *flags);
  command->callback([command, flags, &context] {
    flags->seed_given = command->count("--seed") > 0;
    context.exit_code = run_slam(*flags);
  });
}

}  // namespace rastro::cli
