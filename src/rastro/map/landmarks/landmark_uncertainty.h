// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// Covariance of a landmark's position, the map's unit squared, from the pixels of its observations alone, each with
/// the noise of its pyramid level (1 px on the lowest one); nullopt where they leave its distance open.
std::optional<Eigen::Matrix3d> landmark_covariance(const Map& map, const Landmark& landmark);

}  // namespace rastro
