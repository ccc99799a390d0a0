// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/sensor/source.h"

namespace rastro {

/// What a source holds, for people: format, frames, cameras, depth, ground truth, warnings; some lines of "name value".
std::string describe(const SourceInfo& info, bool with_warnings = true, const LaserScan* first_scan = nullptr);

/// The same for programs.
std::string describe_json(const SourceInfo& info, const LaserScan* first_scan = nullptr);

/// "180 beams from -90 to 89 deg, 0 to 81.83 m".
std::string describe_scan(const LaserScan& scan);

/// "458.654 457.296 367.215 248.375, radial-tangential -0.28 ...", for people.
std::string describe_camera(const Camera& camera);

}  // namespace rastro
