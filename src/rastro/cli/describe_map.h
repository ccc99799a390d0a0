// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/map/file/map_file.h"

namespace rastro::cli {

/// Contents of a map file, as text or as one JSON object.
std::string describe_map(const MapFileReport& report, const std::string& file);
std::string describe_map_json(const MapFileReport& report, const std::string& file);

}  // namespace rastro::cli
