// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/backend/rgbd/options.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// Adds the errors common to all pixels and depths of an image, as from lens and clocks, which do not decrease with
/// their number: `edge_sigma_m`, `edge_sigma_rad`.
Matrix6d with_common_errors(Matrix6d covariance, const RgbdSlamOptions& options);
/// Covariance of a constraint without them, as it adds up along a path: they are nearly the same in successive images.
Matrix6d without_common_errors(const Constraint& edge, const RgbdSlamOptions& options);

}  // namespace rastro
