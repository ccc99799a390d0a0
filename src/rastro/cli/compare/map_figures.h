// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/cli/benchmark/run_figures.h"
#include "rastro/map/cloud/point_cloud.h"
#include "rastro/math/sim3.h"

namespace rastro::cli {

/// What the map of a run is worth where the recording has ground truth for it, as generated rooms have: against
/// truth.ply surface_median_m and surface_complete_percent (as 'rastro export --to ply' and 'rastro evaluate cloud'),
/// and of the lengths of objects.yaml lengths_measured_percent, length_mean_m, length_max_m and length_sigmas (as
/// 'rastro measure'). Nothing where there is no such ground truth, or no map with depth images. The map's world must be
/// the first camera of the recording, in meters.
void add_map_figures(const std::filesystem::path& run_folder, const std::filesystem::path& recording,
                     RunFigures& figures);

/// The length that sets the scale of maps of one camera, by its name in objects.yaml; empty where there is none.
std::string known_length_of_mono_maps(const std::filesystem::path& recording);

/// The surface figures of a cloud of another program: `first_camera_from_cloud`, scale included.
void add_surface_figures(PointCloud cloud, const Sim3& first_camera_from_cloud, const std::filesystem::path& recording,
                         RunFigures& figures);

}  // namespace rastro::cli
