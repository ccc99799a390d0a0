// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "rastro/calibration/live_assistant.h"
#include "rastro/cli/live_sink.h"

namespace rastro::cli {

/// --view of `rastro calibrate LIVE`: the images with the corners found, what the boards so far have shown of the image
/// and of tilts, and where to hold the board next.
class LiveBoards {
 public:
  /// `cameras`: 1, or 2 of a pair, whose images are shown side by side.
  LiveBoards(const ServerFlags& flags, LiveHello run, int cameras);

  /// After each frame that was searched: `found` in it, and what the assistant said of it. Waits while the page has
  /// paused the run.
  void show(const Frame& frame, const FoundBoards& found, LiveAssistant::Answer answer, const LiveAssistant& assistant);
  /// While the source gives no frame.
  void idle(const std::string& line) { sink_.idle(line); }
  void finish(const std::string& line) { sink_.finish(line); }
  void wait_until_closed() { sink_.wait_until_closed(); }

 private:
  void show_image(const Frame& frame, const FoundBoards& found, LiveAssistant::Answer answer);

  int cameras_;
  std::int64_t done_ = 0;
  LiveSink sink_;
};

/// What to do next: of the board as it is, else of what is missing.
std::string board_advice(LiveAssistant::Answer answer, const LiveAssistant& assistant);

}  // namespace rastro::cli
