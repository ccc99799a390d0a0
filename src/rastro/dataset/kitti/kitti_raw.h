// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "rastro/dataset/recording.h"

namespace rastro {

/// timestamps.txt of KITTI raw: one date and time a line, "2011-09-26 13:02:25.964389445". Error naming `where`:line
/// otherwise.
std::vector<TimeNs> parse_kitti_timestamps(std::string_view text, std::string_view where);

/// KITTI raw drive (Geiger et al. 2013): image_00/data and image_00/timestamps.txt, calib_cam_to_cam.txt in the folder
/// or above. nullopt where `path` looks like nothing of the kind.
std::optional<Recording> index_kitti_raw(const std::filesystem::path& path, const OpenOptions& options);

}  // namespace rastro
