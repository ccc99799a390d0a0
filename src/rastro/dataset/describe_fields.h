// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <nlohmann/json.hpp>

#include "rastro/sensor/source.h"

namespace rastro {

/// The fields of a source, for the JSON of info and check. Internal to the dataset module: the only header that shows
/// nlohmann.
nlohmann::ordered_json source_fields(const SourceInfo& info);
/// The shape of a scan, in degrees and meters.
nlohmann::ordered_json scan_fields(const LaserScan& scan);

}  // namespace rastro
