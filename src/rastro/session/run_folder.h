// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/folder_lock.h"
#include "rastro/base/options.h"
#include "rastro/odometry/odometry.h"
#include "rastro/sensor/source.h"
#include "rastro/session/former_run.h"
#include "rastro/track/track_frame.h"

namespace rastro {

/// The folder of one run, written during the run: about.json and options.yaml first, stats.csv and events.jsonl frame
/// by frame, result.json last. A killed run keeps everything written so far and has no result.json.
class RunFolder {
 public:
  /// Creates the folder. A folder that is not empty is an Error unless `overwrite` is given; then the files of an
  /// earlier run are replaced and other files stay. Error also while another run writes to the folder.
  RunFolder(std::filesystem::path folder, bool overwrite);
  /// A run that had no frame leaves the earlier one as it was.
  ~RunFolder();

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }

  void write_options(const OptionTable& options) const;
  /// Version, machine, input and command line.
  void write_about(const SourceInfo& input, const std::string& command_line) const;
  void write_result(const std::string& json) const;

  /// Removes the run's files, and the folder if nothing else is in it: for a run without a frame. The earlier run comes
  /// back, unless this one has a result.
  void discard() const;

  /// One row of stats.csv: counts and the time of each stage in ms.
  void add_stats(const TrackFrame& frame);
  void add_stats(const OdometryUpdate& update);
  /// One line of events.jsonl, which is created with the first event.
  void add_event(std::int64_t frame, const std::string& kind, const std::string& text);

 private:
  std::filesystem::path folder_;
  std::optional<FolderLock> lock_;
  std::unique_ptr<FormerRun> former_;
  std::optional<AppendFile> stats_;
  std::optional<AppendFile> events_;
};

}  // namespace rastro
