// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/viewer/scene.h"

namespace rastro::cli {

/// What `rastro view` shows of a plain recording: its frames on the timeline, with the ground truth or the wheel
/// odometry as trajectory where there is one. Images, depth and scans are read frame by frame on request, in constant
/// memory. Stamps of videos and bags are those of evenly spaced frames. Error where it cannot be opened.
NamedScene recording_scene(const std::string& path);

}  // namespace rastro::cli
