// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/dataset/live/live_camera.h"

namespace rastro {

/// A camera on the network: MJPEG over http(s), or rtsp, by OpenCV's FFmpeg back-end (CMake: RASTRO_WITH_VIDEO). Stamps
/// are times of arrival. Error where it cannot be opened, and where the build cannot.
std::unique_ptr<LiveSource> open_stream(const std::string& address, const OpenOptions& options, Clock& clock);

}  // namespace rastro
