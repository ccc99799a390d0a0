// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace rastro::cli {

/// The whole program: dispatches to a subcommand, prints what went wrong as one line on stderr, returns the exit code.
int run_program(int argc, const char* const* argv);

/// The command line of this process as one could type it again, for about.json.
const std::string& command_line();

}  // namespace rastro::cli
