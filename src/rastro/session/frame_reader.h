// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "rastro/sensor/source.h"
#include "rastro/session/run_folder.h"

namespace rastro {

/// Reads a source to its end. Frames that cannot be read are skipped, counted and written as events.
class FrameReader {
 public:
  /// `folder` may be null.
  FrameReader(Source& source, RunFolder* folder) : source_(source), folder_(folder) {}

  /// The next readable frame, nullopt at the end. Throws errors that prevent further reading.
  std::optional<Frame> next();
  std::int64_t skipped() const { return skipped_; }
  /// Why the first skipped frame could not be read; empty if none was skipped.
  const std::string& first_skip() const { return first_skip_; }

 private:
  Source& source_;
  RunFolder* folder_;
  std::int64_t last_index_ = -1;
  std::int64_t skipped_ = 0;
  std::string first_skip_;
};

}  // namespace rastro
