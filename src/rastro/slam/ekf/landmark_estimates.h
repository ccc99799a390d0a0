// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/slam/ekf/filter.h"
#include "rastro/slam/ekf/observation.h"

namespace rastro {

/// The filter's landmarks without the candidates, by their ids. `records` are those of the filter's landmarks.
std::shared_ptr<const LandmarkLayer> landmark_estimates(const EkfFilter& filter,
                                                        std::span<const LandmarkRecord> records);

}  // namespace rastro
