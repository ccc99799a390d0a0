// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "rastro/dataset/live/live_camera.h"

namespace rastro {

/// How long each try to open a camera again may take: twice as long as the one before, up to a limit, so that a camera
/// that answers slowly is found and a program that is asked to end seldom waits for one that is off.
class ReopenLimit {
 public:
  ReopenLimit(int shortest_ms, int longest_ms)
      : shortest_ms_(shortest_ms), longest_ms_(longest_ms), next_ms_(shortest_ms) {}

  int take_ms() { return std::exchange(next_ms_, std::min(2 * next_ms_, longest_ms_)); }
  void reset() { next_ms_ = shortest_ms_; }

 private:
  int shortest_ms_, longest_ms_, next_ms_;
};

/// A camera on the network: MJPEG over http(s), or rtsp, by OpenCV's FFmpeg back-end (CMake: RASTRO_WITH_VIDEO). Stamps
/// are times of arrival. Error where it cannot be opened, and where the build cannot.
std::unique_ptr<LiveSource> open_stream(const std::string& address, const OpenOptions& options, Clock& clock);

}  // namespace rastro
