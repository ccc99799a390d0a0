// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "rastro/dataset/laser_log/log_words.h"
#include "rastro/dataset/open.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// One kind of text log in which a frame is one line. A parser goes over the file twice: over all of it when it is
/// opened, to learn what only the whole file says, and then frame by frame.
class LogParser {
 public:
  virtual ~LogParser() = default;
  /// The frame of this line; nullopt where it is not a frame. Error where it should be one and is broken: it keeps its
  /// number.
  virtual std::optional<Frame> read(std::string_view line, const LinePosition& position) = 0;
  /// The first pass is over: says what the file holds. `info` has path, frame_count and warnings already.
  virtual void start_over(SourceInfo& info) = 0;
};

/// Error where the log holds no frame that can be read, or the options choose none.
std::unique_ptr<Source> make_log_source(const std::string& path, std::unique_ptr<LogParser> parser,
                                        const OpenOptions& options);

}  // namespace rastro
