// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rastro/map/landmarks/map_scale.h"

namespace rastro::cli {

/// Brings what a run left in its folder to metres, together with its map. Files that are not there are left out; one
/// that is not as a run writes it is an Error, before anything is changed.
void scale_run_folder(const std::filesystem::path& folder, const Map& in_metres, const MapScaleFound& found);

}  // namespace rastro::cli
