// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/image/image.h"
#include "rastro/track/track_frame.h"

namespace rastro {

/// Takes what a tracker says, frame by frame and in order: a file, a picture, a back-end.
class TrackSink {
 public:
  virtual ~TrackSink() = default;
  /// `image` is the frame as the tracker saw it. What is written must survive the program being killed right after.
  virtual void write(const TrackFrame& frame, GreyView image) = 0;
  /// Once, after the last frame, however the run ended.
  virtual void finish() {}
};

}  // namespace rastro
