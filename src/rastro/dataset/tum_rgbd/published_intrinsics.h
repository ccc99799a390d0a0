// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "rastro/sensor/source.h"

namespace rastro {

/// The color camera's intrinsics as published with the TUM RGB-D benchmark, told by the folder's name: freiburg1 or
/// fr1, 2, 3.
std::optional<CalibratedCamera> tum_camera_of_folder(const std::filesystem::path& folder);

}  // namespace rastro
