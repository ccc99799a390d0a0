// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/dataset/live/freenect_system.h"
#include "rastro/dataset/live/live_camera.h"

namespace rastro {

/// The Kinect 1 of this number (empty: 0) through libfreenect: 640x480 at 30 Hz, frames at the color images, each with
/// the depth image of the nearest stamp, which the camera registers to color unless the calibration tells of a depth
/// camera. Without a calibration the usual lens is taken. `system`: null where the build has none; Error then, for what
/// is no number, and where no such Kinect is connected. `system` and `clock` outlive it.
std::unique_ptr<LiveSource> open_freenect(const std::string& address, const std::string& number,
                                          const OpenOptions& options, FreenectSystem* system, Clock& clock);

}  // namespace rastro
