// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "rastro/cli/command.h"

namespace rastro::cli {

/// `rastro evaluate loops`.
void add_evaluate_loops_command(CLI::App& evaluate, Context& context);

}  // namespace rastro::cli
