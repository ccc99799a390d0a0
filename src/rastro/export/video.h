// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "rastro/track/track_sink.h"

namespace rastro {

/// A video of the overlays of a run at the rate of its stamps: Motion JPEG for .avi, MPEG-4 for .mp4.
/// Throws Error for another extension, where the file cannot be made, and where rastro was built without video.
class TrackVideo : public TrackSink {
 public:
  explicit TrackVideo(const std::filesystem::path& path);
  ~TrackVideo() override;
  void write(const TrackFrame& frame, GrayView image) override;
  void finish() override;

 private:
  class Writer;
  std::unique_ptr<Writer> writer_;
};

}  // namespace rastro
