// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rastro/cli/live_places.h"
#include "rastro/cli/live_sink.h"
#include "rastro/session/slam_run.h"
#include "rastro/slam/slam.h"

namespace rastro::cli {

/// --view of `rastro slam` and `rastro localize`: frames, features and the map so far.
class LiveSlam {
 public:
  /// `mapping`: whether the run makes a map, so that it can be asked to only localize, to save it into `folder`, and to
  /// begin another one. `max_memory_bytes`: limit of the run, 0: none; maps are not shown where they would come near
  /// it.
  LiveSlam(const ServerFlags& flags, const LiveHello& run, Slam& method, bool mapping, std::filesystem::path folder,
           std::size_t max_memory_bytes);

  /// After a frame. Waits while the page has paused the run.
  void show(const SlamProgress& progress);
  /// The result of the run, after it.
  void finish(const SlamRunEnd& end);
  void wait_until_closed() { sink_.wait_until_closed(); }
  /// While a live source gives no frame.
  void idle(const std::string& line) { sink_.idle(line); }

 private:
  void show_image(const Frame& frame);
  void show_map();
  void obey(LiveCommand command);
  void set_mapping(bool on);
  /// The map so far as the next free map_NNNN.rastro. Where that fails, the page is told why, and the result is false.
  bool save();
  void reset();

  Slam& method_;
  std::filesystem::path folder_;
  double most_mb_;
  double snapshot_ms_ = 0.0;
  LivePlaces places_;
  LiveSink sink_;  ///< Its threads use what is above.
};

}  // namespace rastro::cli
