// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "rastro/base/append_file.h"
#include "rastro/base/folder_lock.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// Writes frames as they come as a recording that open() reads: EuRoC/ASL (mono, stereo), or TUM RGB-D where there is
/// depth. Images are PNG, so nothing is lost; depth is in the units of the source, so that reading it gives the same
/// meters. Stamps are those of the frames. The calibration of the source is written beside them.
///
/// A frame enters the lists when its files are complete, in one write: a program that is killed leaves a recording of
/// all frames but the one at hand.
class RecordingWriter {
 public:
  /// Error for a source without images, and for a folder that cannot be made, is not empty or is in use.
  RecordingWriter(const SourceInfo& info, const std::filesystem::path& folder);
  ~RecordingWriter();

  /// Color where the frame has it, else gray. Error, naming the file, where it cannot be written; the frames before it
  /// stay.
  void write(const Frame& frame);
  std::int64_t frames() const { return frames_; }

 private:
  class Layout;
  class EurocLayout;
  class TumLayout;

  std::optional<FolderLock> lock_;
  std::unique_ptr<Layout> layout_;
  std::int64_t frames_ = 0;
};

}  // namespace rastro
