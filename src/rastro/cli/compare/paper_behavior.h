// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/paper_table.h"

namespace rastro::cli {

/// Section 8.3 of the comparison paper, which describes in words how fast the four methods were and how they took
/// abrupt motion and loss: on every input with depth the words beside our figures. Recovery is known where the
/// disturbances `covered` and `abrupt` were tried.
std::vector<PaperTable> paper_behavior_tables(const Comparison& comparison);

}  // namespace rastro::cli
