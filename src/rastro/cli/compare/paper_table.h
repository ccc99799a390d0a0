// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/report_text.h"
#include "rastro/cli/compare/svg_chart.h"

namespace rastro::cli {

/// A table or the figures of a publication beside ours.
struct PaperTable {
  std::string title;
  TextRows rows;              ///< With a head.
  std::string note;           ///< What ours and theirs do not have in common; may be empty.
  std::vector<Chart> charts;  ///< Of the page only.
};

}  // namespace rastro::cli
