// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// Landmarks of a filter in the plane, those with estimates, as CSV with a header: id, sensor_id, x and y (m), cov_xx,
/// cov_xy, cov_yy (m^2), observations.
std::string landmarks_csv(const LandmarkLayer& layer);

}  // namespace rastro
