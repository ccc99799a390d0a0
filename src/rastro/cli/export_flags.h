// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/export_input.h"

namespace rastro::cli {

/// Error for a flag (of those that were given) that does not apply to an export of this input as `to`.
void refuse_unused_flags(const std::vector<std::string>& given, const std::string& to, const ExportInput& input);

/// Error where an export as `to` has room for the poses of one submap alone: each is in a frame of its own.
void refuse_all_submaps(const std::string& to, const ExportInput& input);

/// The map without the landmarks that have fewer than `min_count` observations or that no keyframe observes from nearer
/// than `max_depth` (along its optical axis, in the map's unit).
std::shared_ptr<const Map> with_landmarks_within(const Map& map, std::size_t min_count, double max_depth);

}  // namespace rastro::cli
