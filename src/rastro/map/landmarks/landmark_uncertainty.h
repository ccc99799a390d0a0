// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// Covariance of a landmark's position, the map's unit squared, from its observations alone: pixels and disparities
/// with the noise of their pyramid level (1 px on the lowest one), and measured depths. nullopt where they do not
/// determine its distance.
std::optional<Eigen::Matrix3d> landmark_covariance(const Map& map, const Landmark& landmark);

}  // namespace rastro
