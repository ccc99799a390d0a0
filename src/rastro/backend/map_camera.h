// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/camera/camera.h"

namespace rastro {

/// For a map whose keyframes a run uses with its own camera: Error, naming --map, unless both cameras are the same. The
/// calibrations of one camera differ by less than 1 % of the width.
void require_camera_of_map(const Camera& of_map, const Camera& of_run);

}  // namespace rastro
