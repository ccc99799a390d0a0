// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <memory>

#include "rastro/map/file/row_source.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// The map that rows of a version hold, not yet checked for contradictions. Error where its head is missing, or where
/// `rows` refuses one.
std::shared_ptr<Map> read_map(RowSource& rows, std::uint32_t version);

/// Version 1, maps of a depth camera, and version 2, maps of landmarks, in the form of today.
std::shared_ptr<Map> read_depth_camera_map(RowSource& rows);
std::shared_ptr<Map> read_landmark_map(RowSource& rows);
/// Which of both a head is of.
bool is_landmark_head(std::string_view body);

/// Hands the head to `read`: that of the table `head`, else its copy. False where neither can be read.
bool with_head(RowSource& rows, const RowSource::Read& read);

/// Takes away what leads nowhere: of a run that was killed, or of a damaged file.
void repair(Map& map);

}  // namespace rastro
