// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "rastro/base/clock.h"
#include "rastro/base/error.h"
#include "rastro/dataset/image_file.h"
#include "rastro/dataset/open.h"
#include "rastro/sensor/live_source.h"

namespace rastro {

/// The device does not answer any more: unplugged, closed, forbidden.
class DeviceGone : public Error {
 public:
  using Error::Error;
};

/// A camera that is open.
class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  /// The next image with its stamp (nanoseconds since 1970) and the time of its exposure, waiting at most about
  /// `patience`; number and name are left to the caller. nullopt: none came. Throws DeviceGone, and Error for an image
  /// that cannot be used.
  virtual std::optional<ArrivedFrame> next(TimeNs patience) = 0;
  /// No image will ever come, not even from the device opened anew: the end of a file or a pipe.
  virtual bool has_ended() const { return false; }
};

struct LiveCameraOptions {
  TimeNs stall_after = 2 * ns_per_second;  ///< Without an image for so long, it is stalled.
  TimeNs retry_every = ns_per_second / 2;  ///< A device that is gone is opened again so often.
};

/// Opens the device; throws Error where that fails.
using OpenDevice = std::function<std::unique_ptr<CameraDevice>()>;

/// A camera that may stall, be unplugged and return: what happens is its condition(), and it is opened again until it
/// is back. `device`: already open, so that a camera that was never there is an error of whoever opens it. Frames are
/// numbered from 0 and chosen as `choice` says. `clock` outlives it.
std::unique_ptr<LiveSource> make_live_camera(SourceInfo info, std::unique_ptr<CameraDevice> device, OpenDevice reopen,
                                             const OpenOptions& choice, const LiveCameraOptions& options, Clock& clock);

/// What is known of a camera before its first image: calibration as given by the options. `format`: "live_v4l2", ....
SourceInfo camera_info(const std::string& address, const std::string& format, std::optional<ImageSize> size,
                       const OpenOptions& options);

/// Nanoseconds since 1970 minus those of `clock`, for stamps.
TimeNs epoch_offset(const Clock& clock);

}  // namespace rastro
