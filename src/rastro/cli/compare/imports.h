// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/benchmark/run_figures.h"
#include "rastro/cli/compare/comparison.h"

namespace rastro::cli {

/// A result of another program, as a further column.
struct Import {
  std::string name;
  std::string input;  ///< Name of the input; empty: the only one.
  std::string trajectory;
  std::string cloud;  ///< PLY in the world of the trajectory; empty: none.
  std::string alignment = "se3";
  bool of_body = false;  ///< Poses of the body instead of the camera.
};

/// NAME[@INPUT]=trajectory.txt[,cloud.ply][,none|se3|sim3|yaw|origin][,body]. Error for anything else, and for files
/// that are not there.
Import parse_import(const std::string& text);

/// An import with its figures.
struct ScoredImport {
  ImportedTrajectory what;
  RunFigures figures;
};

/// Scores each against the ground truth of its input at the chosen frames (of a world: of its first seed).
/// `recordings`: folder of each input; `columns`: names that are taken. Error for an unknown input, one without ground
/// truth, a name that is taken, and files that cannot be read or have no pose of the input.
std::vector<ScoredImport> score_imports(const std::vector<Import>& imports, const std::vector<CompareInput>& inputs,
                                        const std::vector<std::string>& recordings,
                                        const std::vector<std::string>& columns);

/// Into the table.
void add_imports(const std::vector<ScoredImport>& imports, Comparison& comparison);

}  // namespace rastro::cli
