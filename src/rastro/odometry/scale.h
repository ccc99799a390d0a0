// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// Metres of a unit of `trajectory`: the scale of the similarity that brings its places nearest to those of `reference`
/// at the same stamps (Umeyama 1991). nullopt where they share too little or one of them stands still.
std::optional<double> scale_from_reference(const Trajectory& trajectory, const Trajectory& reference);

/// Multiplies all lengths, around the first pose.
void scale_trajectory(Trajectory& trajectory, double factor);

/// Metres of the way from the first pose to the last.
double path_length(const Trajectory& trajectory);

}  // namespace rastro
