// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/dataset/live/live_camera.h"
#include "rastro/dataset/live/v4l2_system.h"

namespace rastro {

/// What is wanted of a camera: "/dev/video0", "/dev/video0,1280x720", "/dev/video0,1280x720@30,MJPG".
struct V4l2Request {
  std::string file;
  std::optional<ImageSize> size;  ///< nullopt: 640x480, or what the driver has near that.
  double rate_hz = 30.0;
  std::string format;  ///< YUYV, MJPG or GREY; empty: the first of GREY, YUYV, MJPG that reaches the rate.
};

/// Error for text that is no request.
V4l2Request parse_v4l2_request(const std::string& text);

/// A camera of the kernel's Video4Linux2. Stamps are the driver's, where it has any. Error where it cannot be opened,
/// is no camera, or has no format that can be used; the messages say what to do. Both outlive it.
std::unique_ptr<LiveSource> open_v4l2(const std::string& address, const std::string& request,
                                      const OpenOptions& options, V4l2System& system, Clock& clock);

/// One mode of a camera.
struct V4l2Mode {
  std::string format;
  ImageSize size;
  std::vector<double> rates_hz;  ///< Highest first.
};

/// A device file as `rastro devices` shows it.
struct V4l2Listing {
  std::string file, name;
  std::string problem;  ///< Why it cannot be used, with what to do; empty if it can.
  std::vector<V4l2Mode> modes;
};

/// Device files that are no cameras (metadata, outputs) are left out.
std::vector<V4l2Listing> list_v4l2(V4l2System& system);

}  // namespace rastro
