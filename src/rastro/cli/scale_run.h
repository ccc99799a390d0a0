// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rastro/map/landmarks/map_scale.h"

namespace rastro::cli {

/// Makes the files of a run folder and its map metric. Files that are missing are skipped; one that is not as a run
/// writes it is an Error, before anything is changed.
void scale_run_folder(const std::filesystem::path& folder, const Map& in_meters, const MapScaleFound& found);

}  // namespace rastro::cli
