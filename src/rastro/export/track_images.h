// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rastro/track/track_sink.h"

namespace rastro {

/// One PNG per frame: positions in red, ids in green, the frame's counts above. Named by the frame's number.
class TrackImages : public TrackSink {
 public:
  /// Creates the folder.
  explicit TrackImages(std::filesystem::path folder);
  void write(const TrackFrame& frame, GrayView image) override;

 private:
  std::filesystem::path folder_;
};

}  // namespace rastro
