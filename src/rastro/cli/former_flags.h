// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace rastro::cli {

/// The command line with the flags of the last release, as `--flag` or `--flag=value`, replaced by those of today. Logs
/// a warning with the new name for each, except with --quiet. What follows `--` is kept.
std::vector<std::string> with_current_flags(int argc, const char* const* argv);

}  // namespace rastro::cli
