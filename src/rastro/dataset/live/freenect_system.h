// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/time.h"

namespace rastro {

/// An image as a Kinect gives it, 640x480.
struct FreenectImage {
  std::vector<std::uint8_t> bytes;  ///< Color: red, green, blue; depth: millimeters, 16 bits, 0 is none.
  std::uint32_t ticks = 0;          ///< Of the camera's clock of 60 MHz, which begins anew every 71.6 s.
};

/// A Kinect that is open and sends images.
class FreenectCamera {
 public:
  virtual ~FreenectCamera() = default;
  /// Lets images arrive, for at most so long. False: the camera is gone.
  virtual bool wait(TimeNs at_most) = 0;
  /// The newest one that was not taken.
  virtual std::optional<FreenectImage> take_color() = 0;
  virtual std::optional<FreenectImage> take_depth() = 0;
};

/// What is used of libfreenect; a test has one that plays a Kinect.
class FreenectSystem {
 public:
  virtual ~FreenectSystem() = default;
  virtual std::vector<std::string> serials() = 0;  ///< Of the cameras that are connected.
  /// `registered`: depth is put into the color image by the tables of the camera. Null: it cannot be opened.
  virtual std::unique_ptr<FreenectCamera> open(int number, bool registered) = 0;
};

/// That of the machine (CMake: RASTRO_WITH_FREENECT); null where the build has no libfreenect.
FreenectSystem* freenect_system();

}  // namespace rastro
