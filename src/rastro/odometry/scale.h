// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/sensor/trajectory.h"

namespace rastro {

/// Meters per unit of `trajectory`: the scale of the similarity that aligns its positions best with those of
/// `reference` at the same stamps (Umeyama 1991). nullopt with too few common stamps or if one of them is at rest.
std::optional<double> scale_from_reference(const Trajectory& trajectory, const Trajectory& reference);

/// Multiplies all lengths, around the first pose.
void scale_trajectory(Trajectory& trajectory, double factor);

/// Path length in meters.
double path_length(const Trajectory& trajectory);

}  // namespace rastro
