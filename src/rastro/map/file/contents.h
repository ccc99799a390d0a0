// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/map/file/database.h"

namespace rastro {

/// Rows of the table `contents`: the table of contents, which only a finished file has, and a second copy of the head,
/// so that one lost page does not cost the camera.
constexpr std::int64_t contents_row = 0, second_head_row = 1;

/// Number of rows of each table and the hash of their checksums.
std::string contents_body(const Database& database);

/// Whether the run that made the file finished. Error where the file does not match its table of contents.
bool is_finished(const Database& database);

}  // namespace rastro
