// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/dataset/image_file.h"
#include "rastro/dataset/open.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// One frame of a recording kept as image files: where they lie and when they were taken. What is not there is empty.
struct RecordedFrame {
  TimeNs stamp = 0;
  std::string image;
  std::string right;
  std::string depth;
  TimeNs depth_stamp = 0;
};

/// Everything that a reader of one format finds out; the images themselves are read later, one by one.
struct Recording {
  SourceInfo info;
  std::vector<RecordedFrame> frames;  ///< In the order of the recording's list, stamps as they stand there.
  std::string stamp_unit = "s";  ///< What the stamps are written in; "date" for KITTI raw, "" where there are none.
};

/// Finds the format of `path` and reads its lists; nullopt for a video, which has no list of files.
std::optional<Recording> index_recording(const std::string& path, const OpenOptions& options);

/// Frames first, first + every, ... below end: which of `count` frames the options choose.
struct FrameChoice {
  std::int64_t first = 0;
  std::int64_t every = 1;
  std::int64_t count = 0;

  FrameChoice() = default;
  /// Error where the options are out of range or choose nothing.
  FrameChoice(const OpenOptions& options, std::int64_t frame_count, const std::string& path);
  std::int64_t index(std::int64_t k) const { return first + k * every; }
};

/// Reads the chosen frames of a recording, seeking rather than skipping.
std::unique_ptr<Source> make_recording_source(Recording recording, const OpenOptions& options);

/// Made-up stamps at rate_hz from 0, without drift: frame k is at k / rate seconds, rounded to the nanosecond.
TimeNs made_up_stamp(std::int64_t frame, double rate_hz);

}  // namespace rastro
