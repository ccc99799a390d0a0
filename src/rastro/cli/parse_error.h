// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace rastro::cli {

/// Throws Error naming the nearest command when the first word is not one.
void refuse_unknown_command(const CLI::App& app, int argc, const char* const* argv);

/// What is wrong with the command line, in one line that names the nearest flag of the command where a flag is unknown.
std::string parse_error_line(const CLI::App& app, const CLI::ParseError& error);

/// Error for a word such as `--out=`: CLI11 takes the next word for the value.
void refuse_empty_values(const std::vector<std::string>& words);

}  // namespace rastro::cli
