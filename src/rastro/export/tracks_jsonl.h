// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rastro/base/append_file.h"
#include "rastro/track/track_sink.h"

namespace rastro {

/// tracks.jsonl: one JSON object per line and frame; `ray` is null without a calibration.
class TracksJsonl : public TrackSink {
 public:
  explicit TracksJsonl(const std::filesystem::path& path) : file_(path) {}
  void write(const TrackFrame& frame, GrayView image) override;

 private:
  AppendFile file_;
};

}  // namespace rastro
