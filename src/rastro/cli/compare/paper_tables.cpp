// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/paper_tables.h"

#include "rastro/cli/compare/paper_behavior.h"
#include "rastro/cli/compare/paper_front_end.h"
#include "rastro/cli/compare/paper_lengths.h"
#include "rastro/cli/compare/paper_positioning.h"

namespace rastro::cli {

std::vector<PaperTable> paper_tables(const Comparison& comparison, const std::vector<ColumnTrace>& traces) {
  std::vector<PaperTable> tables = paper_length_tables(comparison);
  const auto append = [&tables](std::vector<PaperTable> more) {
    for (PaperTable& table : more) tables.push_back(std::move(table));
  };
  append(paper_behavior_tables(comparison));
  append(paper_front_end_tables(comparison));
  append(paper_positioning_tables(comparison, traces));
  return tables;
}

/// Both rooms, and as many frames of a drive as the positioning paper shows.
std::vector<std::string> paper_inputs() { return {"bedroom", "study", "street --frames 320"}; }

std::vector<std::string> paper_methods(const InputFacts& facts) {
  if (facts.has_depth) return {"slam/rtabmap:rgbd", "orb:rgbd", "lsd:rgbd", "slam/rgbd", "orb:mono", "lsd:mono"};
  return {"odometry/classic", "odometry/profiles", "odometry/hybrid", "odometry/features"};
}

std::vector<std::string> paper_disturbances() { return {"covered", "abrupt"}; }

}  // namespace rastro::cli
