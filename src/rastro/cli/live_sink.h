// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rastro/base/stopwatch.h"
#include "rastro/cli/server_flags.h"
#include "rastro/session/slam_run.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"
#include "rastro/viewer/live_view.h"

namespace rastro::cli {

/// --view: shows a run in a browser while it goes on, and does what the page asks for, between frames.
class LiveSink {
 public:
  /// Prints the page's address on standard error, with a token in any case: whoever has it can end the run. `mapping`:
  /// whether the run makes a map, so that it can be asked to only localize. `max_memory_bytes`: limit of the run, 0:
  /// none; maps are not shown where they would come near it.
  LiveSink(const ServerFlags& flags, const LiveHello& run, Slam& method, bool mapping, std::size_t max_memory_bytes);

  /// After a frame. Waits while the page has paused the run.
  void show(const SlamProgress& progress);
  /// The result of the run, after it.
  void finish(const SlamRunEnd& end);
  /// Returns when no page is open any more, or at Ctrl-C.
  void wait_until_closed();

 private:
  void show_frame(const SlamProgress& progress);
  void show_image(const SlamProgress& progress);
  void show_map();
  void obey(LiveCommand command);
  void set_mapping(bool on);
  void say(const std::string& line);

  Slam& method_;
  double most_mb_;
  LiveStatus status_;
  bool steps_ = false;  ///< Paused again after the next frame.
  Stopwatch since_begin_;
  double snapshot_ms_ = 0.0;
  LiveView view_;
};

}  // namespace rastro::cli
