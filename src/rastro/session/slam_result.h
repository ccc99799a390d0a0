// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/input_check/input_warning.h"
#include "rastro/map/graph/map.h"
#include "rastro/session/live_statistics.h"
#include "rastro/session/method_in_use.h"
#include "rastro/session/time_histogram.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Time of one stage over the frames in which it ran.
struct SlamStage {
  std::string name;
  TimeHistogram times;
};

/// Frames in each state, as first reported.
struct SlamStateCounts {
  std::int64_t tracking = 0, weak = 0, lost = 0, relocalized = 0, initializing = 0;
};

struct SlamTiming {
  TimeHistogram frames;
  std::vector<SlamStage> stages;       ///< In the order of their first occurrence.
  double recording_seconds = 0.0;      ///< From the first stamp to the last one.
  double method_seconds = 0.0;         ///< Of the method alone, without reading.
  std::int64_t dropped_frames = 0;     ///< Frames that a live run could not map because mapping fell behind; else 0.
  std::optional<LiveStatistics> live;  ///< Of a live run.

  /// Seconds of recording processed per second; nullopt if nothing was measured.
  std::optional<double> times_real_time() const;
};

struct SlamMemory {
  double peak_mb = 0.0;  ///< Of the program, 10^6 bytes.
  MapMemory map;         ///< Of the map alone at the end, by the method's own count.
};

/// The result of a run; the fields of its result.json. Percentages are 0 to 100.
struct SlamResult {
  MethodInUse method;
  std::int64_t frames = 0;          ///< Processed.
  std::int64_t skipped_frames = 0;  ///< Could not be read.
  SlamStateCounts states;
  std::map<std::string, std::int64_t> reasons;  ///< How often each reason was given.
  double coverage = 0.0;                        ///< Frames with a pose in percent of the frames asked for.
  /// Frames with a measured pose (neither lost nor extrapolated) in percent of the frames asked for.
  double recall = 0.0;
  std::optional<double> seconds_to_first_pose;  ///< Of the recording; nullopt: there was none.
  std::int64_t loops_closed = 0, keyframes = 0, submaps = 0, landmarks = 0;
  std::optional<MapScale> scale;  ///< Of the map, if there is one.
  double path_length = 0.0;       ///< Of the final trajectory, meters, or the map's unit where `scale` is not metric.
  SlamTiming timing;
  SlamMemory memory;
  InputWarnings warnings;     ///< What the input contradicts: its calibration, or its other sensors.
  std::string result_sha256;  ///< Of trajectory.txt and the files of the map.
  bool interrupted = false;
  std::string ended;  ///< "end of data", "interrupted", or the error that ended the run.
};

std::string to_json(const SlamResult& result);

/// The numbers of result.json by name, such as "coverage".
std::vector<std::pair<std::string, double>> numbers_of(const SlamResult& result);
/// Those that a limit can name: also the numbers of a live run, 0 in others.
std::vector<std::pair<std::string, double>> limit_numbers_of(const SlamResult& result);

}  // namespace rastro
