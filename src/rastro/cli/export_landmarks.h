// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "rastro/map/landmark/landmark_map.h"

namespace rastro::cli {

/// What there is to say of an export, in order.
using LandmarkExportFacts = std::vector<std::pair<std::string, std::size_t>>;

/// Writes a map of landmarks as `to`: ply, landmarks, g2o, colmap, colmap-binary, svg or png. Error for anything else,
/// which is made from maps of a depth camera.
LandmarkExportFacts export_landmarks(const LandmarkMap& map, const std::string& to, const std::filesystem::path& out,
                                     int submap);

}  // namespace rastro::cli
