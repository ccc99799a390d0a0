// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rastro/dataset/live/live_camera.h"

namespace rastro {

/// A depth camera through OpenNI2 (Xtion, Astra, some Kinects), or a recording of one (.oni), which plays at its own
/// pace. `file`: the recording, or the URI of a camera; empty: the first camera that is connected. CMake:
/// RASTRO_WITH_OPENNI2. Depth is registered to color by the device, where it can, unless the calibration tells of a
/// depth camera; frames come at the color images, each with the depth image of the nearest stamp. Error where none is
/// connected, and where the build cannot.
std::unique_ptr<LiveSource> open_openni2(const std::string& address, const std::string& file,
                                         const OpenOptions& options, Clock& clock);

struct Openni2Listing {
  std::string uri, name;
};

/// Connected cameras; empty also where the build has no OpenNI2.
std::vector<Openni2Listing> list_openni2();
bool has_openni2();

}  // namespace rastro
