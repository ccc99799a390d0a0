// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/base/time.h"
#include "rastro/image/image.h"

namespace rastro {

/// One instant of a camera source. What a source does not have stays empty.
struct Frame {
  std::int64_t index =
      0;  ///< Running number in the source, from 0; of the recording, not of the frames chosen with --frames.
  TimeNs stamp = 0;    ///< Of the (left) image.
  std::string name;    ///< File name or frame number, for messages.
  GreyImage image;     ///< Grey, left or only camera.
  GreyImage right;     ///< Grey, right camera of a stereo pair.
  ColourImage colour;  ///< Only where the source was opened with `want_colour`.
  DepthImage depth;    ///< Metres, 0 = none, in the left camera.
  TimeNs depth_stamp = 0;
};

}  // namespace rastro
