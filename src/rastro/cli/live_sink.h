// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "rastro/base/stopwatch.h"
#include "rastro/cli/run_flags.h"
#include "rastro/viewer/live_view.h"

namespace rastro::cli {

/// --view: shows a run in a browser while it goes on, and does what the page asks for, between frames. What is common
/// to all kinds of runs; they add what they show.
class LiveSink {
 public:
  /// Prints the page's address on standard error, with a token in any case: whoever has it can end the run. Every run
  /// can be paused, stepped and ended; `more` are the commands of this one, done by `obey`.
  LiveSink(const ServerFlags& flags, LiveHello run, const std::vector<LiveCommand>& more = {},
           std::function<void(LiveCommand)> obey = {}, LiveView::PlaceOf place_of = {});

  bool is_watched() const { return view_.is_watched(); }
  /// `rate_hz` and `memory_mb` are set here.
  void show(LiveFrame frame);
  LiveView& view() { return view_; }
  /// While a live source gives no frame: does what pages asked for, and shows why, unless `line` is empty.
  void idle(const std::string& line);
  /// After each frame: does what pages asked for, and waits while one paused the run.
  void obey_pages();

  std::optional<bool> mapping() const { return status_.mapping; }
  void set_mapping(bool on) { status_.mapping = on; }
  void say(const std::string& line);
  /// The frames from now on are of another map.
  void count_reset() { ++status_.resets; }
  /// After the run. `line`: its result.
  void finish(const std::string& line);
  /// Returns when no page is open any more, or at Ctrl-C.
  void wait_until_closed();

 private:
  void take_commands();
  void obey(LiveCommand command);

  std::function<void(LiveCommand)> obey_more_;
  LiveStatus status_;
  bool steps_ = false;         ///< Paused again after the next frame.
  bool shows_source_ = false;  ///< Why the source gives no frame.
  Stopwatch since_begin_;
  LiveView view_;
};

/// Index into scene_state_names().
std::size_t scene_state_of(const std::string& name);

/// What the page is told of a run. Error where flags of --view are given without it; nullopt without it.
std::optional<LiveHello> live_hello(const RunFlags& flags, const std::string& method,
                                    std::optional<std::int64_t> frames);

}  // namespace rastro::cli
