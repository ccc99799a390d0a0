// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/map/snapshot.h"

namespace rastro {

/// Landmarks of a planar map as CSV with a header: id, sensor_id, x and y (m), cov_xx, cov_xy, cov_yy (m^2),
/// observations.
std::string landmarks_csv(const std::vector<PlanarLandmark>& landmarks);

}  // namespace rastro
