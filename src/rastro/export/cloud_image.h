// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "rastro/map/cloud/point_cloud.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// A picture shows hardly more; a larger cloud only takes longer to draw.
constexpr std::size_t most_drawn_points = 2'000'000;

/// A PNG of at most 1600 pixels a side: the cloud in its colors from above (up as find_upright() has it; what is
/// higher than the cameras, such as a ceiling, is omitted), the path blue from the green start to the red end, and a
/// bar of 1 m. Where the unit is none ("units"), the image is as large as it may be. `trajectory` is world_from_camera.
/// Error naming the file where it cannot be written.
void write_cloud_image(const PointCloud& cloud, const Trajectory& trajectory, const std::string& file,
                       const std::string& unit = "m");

}  // namespace rastro
