// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/image.h"
#include "rastro/track/track_frame.h"

namespace rastro {

/// Receives the tracker's results frame by frame, in order: a file, an image, a back end.
class TrackSink {
 public:
  virtual ~TrackSink() = default;
  /// `image` is the frame as the tracker saw it. What is written must survive if the program is killed right after.
  virtual void write(const TrackFrame& frame, GrayView image) = 0;
  /// Called once, after the last frame, however the run ended.
  virtual void finish() {}
};

}  // namespace rastro
