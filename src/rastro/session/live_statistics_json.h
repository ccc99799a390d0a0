// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "rastro/session/live_statistics.h"

namespace rastro {

/// The field "live" of result.json.
nlohmann::ordered_json json_of(const LiveStatistics& statistics);

}  // namespace rastro
