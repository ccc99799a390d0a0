// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rastro/track/track_table.h"

namespace rastro {

/// The tracks of a run: of a run folder (its tracks.csv, else its tracks.yaml) or of one such file. The times of the
/// frames are not in there and stay 0. A last frame cut off by a killed run is omitted. Error when there is none.
TrackTable read_tracks(const std::filesystem::path& run_folder_or_file);

}  // namespace rastro
