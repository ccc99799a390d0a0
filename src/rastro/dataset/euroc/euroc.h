// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "rastro/dataset/recording.h"
#include "rastro/dataset/stamped_list.h"

namespace rastro {

/// camN/data.csv: "stamp[ns],file" a line. Error naming `where`:line for anything else.
ImageList parse_euroc_image_list(std::string_view text, std::string_view where);

/// leica0/data.csv: "stamp,x,y,z" a line; the rotations are set to the identity.
Trajectory parse_leica_positions(std::string_view text, std::string_view where,
                                 StampUnit unit = StampUnit::nanoseconds);

/// T_BS (body_from_sensor) of any sensor.yaml. Error where it is missing or no rigid motion within 0.02.
SE3 parse_sensor_pose(std::string_view text, std::string_view where);

/// EuRoC/ASL folder (Burri et al. 2016): the folder that holds mav0, mav0 itself, or one camera's folder in it.
/// nullopt where `path` looks like nothing of the kind.
std::optional<Recording> index_euroc(const std::filesystem::path& path, const OpenOptions& options);

}  // namespace rastro
