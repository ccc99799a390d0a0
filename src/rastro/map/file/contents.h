// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/map/file/database.h"

namespace rastro {

/// Rows of the table `contents`: the table of contents, which only a finished file has, and the head once more, so that
/// one lost page does not cost the camera.
constexpr std::int64_t contents_row = 0, second_head_row = 1;

/// How many rows each table has and what their checksums come to.
std::string contents_body(const Database& database);

/// Whether the run that made the file came to its end. Error where the file does not hold what its table of contents
/// says.
bool is_finished(const Database& database);

}  // namespace rastro
