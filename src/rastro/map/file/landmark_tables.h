// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include "rastro/map/file/database.h"
#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

/// Makes the tables, which hold `before` (null: nothing), hold `now`; writes what differs and nothing else.
void write_changes(const LandmarkMap* before, const LandmarkMap& now, Database& database);

/// Error where a row is damaged or the rows contradict each other.
LandmarkMap read_landmark_map(const Database& database);

}  // namespace rastro
