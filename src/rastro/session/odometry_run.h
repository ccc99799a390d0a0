// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "rastro/input_check/input_warning.h"
#include "rastro/odometry/odometry.h"
#include "rastro/sensor/source.h"
#include "rastro/session/live_input.h"
#include "rastro/session/method_in_use.h"
#include "rastro/session/run_folder.h"

namespace rastro {

/// Progress of the run, after each frame.
struct OdometryProgress {
  std::int64_t done = 0;               ///< Frames processed or skipped.
  std::optional<std::int64_t> frames;  ///< Total number of frames, if known.
  const OdometryUpdate* last = nullptr;
};

/// The parts of one run. They must outlive odometry_run().
struct OdometryRun {
  Source* source = nullptr;
  LiveInput* live = nullptr;  ///< `source` in a live run, else null.
  Odometry* method = nullptr;
  RunFolder* folder = nullptr;              ///< May be null: no stats, no events, no poses.
  const std::atomic<bool>* stop = nullptr;  ///< Set from outside (Ctrl-C): the run ends after the current frame.
  std::optional<std::int64_t> frames_asked;
  std::function<void(const OdometryProgress&)> progress;
  /// Called for every frame with its update. May be unset.
  std::function<void(const Frame&, const OdometryUpdate&)> watch;
};

/// The result of a run; the fields of its result.json. Percentages are 0 to 100.
struct OdometryResult {
  MethodInUse method;
  std::int64_t frames = 0;                                          ///< Processed.
  std::int64_t skipped_frames = 0;                                  ///< Could not be read.
  std::int64_t tracking = 0, weak = 0, lost = 0, initializing = 0;  ///< Frames in each state, as first reported.
  std::int64_t unused_frames = 0;                                   ///< Without information, left out.
  std::map<std::string, std::int64_t> reasons;                      ///< How often each reason was given.
  double coverage = 0.0;           ///< Frames with a pose in percent of the frames asked for.
  double path_length = 0.0;        ///< Of the final trajectory.
  std::string scale = "relative";  ///< Or the source of the metric scale.
  double ms_per_frame_mean = 0.0, ms_per_frame_p95 = 0.0;
  double peak_memory_mb = 0.0;
  std::optional<LiveStatistics> live;  ///< Of a live run.
  InputWarnings warnings;              ///< What the input contradicts: its calibration, or its other sensors.
  std::string result_sha256;           ///< Of trajectory.txt.
  bool interrupted = false;
  std::string ended;  ///< "end of data", "interrupted", or the error that ended the run.
};

std::string to_json(const OdometryResult& result);

struct OdometryRunEnd {
  OdometryResult result;
  Trajectory trajectory;  ///< Final, world_from_camera.
  std::exception_ptr failure;
  std::string first_skip;  ///< Why the first skipped frame could not be read.
};

/// Runs the method over the source. Writes each pose as first estimated (trajectory_online.txt), and each change of
/// state or reason as an event. Frames that cannot be read are skipped, counted and reported.
OdometryRunEnd odometry_run(const OdometryRun& run);

}  // namespace rastro
