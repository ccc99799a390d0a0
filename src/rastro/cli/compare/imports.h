// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"

namespace rastro::cli {

/// A result of another program, as a further column.
struct Import {
  std::string name;
  std::string input;  ///< Name of the input; empty: the only one.
  std::string trajectory;
  std::string cloud;  ///< PLY in the world of the trajectory; empty: none.
  std::string alignment = "se3";
};

/// NAME[@INPUT]=trajectory.txt[,cloud.ply][,se3|sim3|yaw]. Error for anything else, and for files that are not there.
Import parse_import(const std::string& text);

/// Scores each against the ground truth of its input (of a world: of its first seed) and adds its figures to the
/// table. `recordings`: folder of each input. Error for an unknown input, one without ground truth, and files that
/// cannot be read.
void add_imports(const std::vector<Import>& imports, const std::vector<std::string>& recordings,
                 Comparison& comparison);

}  // namespace rastro::cli
