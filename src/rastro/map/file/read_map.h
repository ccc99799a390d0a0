// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <memory>

#include "rastro/map/file/row_source.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// The map in the rows of a version, not yet checked for contradictions. Error where its head is missing, or where
/// `rows` refuses one.
std::shared_ptr<Map> read_map(RowSource& rows, std::uint32_t version);

/// Version 1, maps of a depth camera, and version 2, maps of landmarks, converted to the current form.
std::shared_ptr<Map> read_depth_camera_map(RowSource& rows);
std::shared_ptr<Map> read_landmark_map(RowSource& rows);
/// Whether a head is that of a landmark map.
bool is_landmark_head(std::string_view body);

/// Passes the head to `read`: that of the table `head`, else its copy. False where neither can be read.
bool with_head(RowSource& rows, const RowSource::Read& read);

/// Removes dangling references and constraints with a fault: of a killed run, or of a damaged file.
void repair(Map& map);

}  // namespace rastro
