// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/task_pool.h"
#include "rastro/export/mcap/mcap_run.h"
#include "rastro/odometry/odometry.h"
#include "rastro/sensor/source.h"
#include "rastro/session/odometry_run.h"
#include "rastro/session/slam_run.h"

namespace rastro::cli {

/// --mcap: an MCAP file that grows with the run. Each frame's pose as first estimated, changes of its state, its
/// events and the images of keyframes are written as they come; the final trajectory and the map at the end.
class McapSink {
 public:
  /// `out`: folder of the run, by which the file's content is called. Error where the file cannot be written, or rastro
  /// was built without MCAP.
  McapSink(const std::string& file, const std::string& out, const std::string& method, const SourceInfo& source);

  void add(const Frame& frame, const SlamUpdate& update);
  void add(const Frame& frame, const OdometryUpdate& update);
  void finish(const SlamRunEnd& end, TaskPool& pool);
  void finish(const OdometryRunEnd& end, TaskPool& pool);

 private:
  void add_state(TimeNs stamp, const std::string& state, const std::string& why);
  void finish(std::shared_ptr<const Map> map, const Trajectory& trajectory, TaskPool& pool);

  std::string out_;
  Trajectory online_;
  std::string last_state_;  ///< With its reason.
  AppendFile file_;
  McapRecorder recorder_;
};

/// Null for an empty name.
std::unique_ptr<McapSink> mcap_sink(const std::string& file, const std::string& out, const std::string& method,
                                    const SourceInfo& source);

}  // namespace rastro::cli
