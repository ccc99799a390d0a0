// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/map/graph/map.h"
#include "rastro/session/time_histogram.h"

namespace rastro {

/// Time of one stage over the frames in which it ran.
struct SlamStage {
  std::string name;
  TimeHistogram times;
};

/// What a run came to; the fields of its result.json. Percentages are 0 to 100.
struct SlamResult {
  std::string method;
  std::int64_t frames = 0;          ///< Processed.
  std::int64_t skipped_frames = 0;  ///< Could not be read.
  /// Frames in each state, as first said.
  std::int64_t tracking = 0, weak = 0, lost = 0, relocalised = 0, initialising = 0;
  std::map<std::string, std::int64_t> reasons;  ///< How often each reason was given.
  double coverage = 0.0;                        ///< Frames with a pose in percent of the frames asked for.
  double recall =
      0.0;  ///< Frames with a pose that was seen, neither lost nor carried on, in percent of those asked for.
  std::optional<double> seconds_to_first_pose;  ///< Of the recording; nullopt: there was none.
  std::int64_t loops_closed = 0, keyframes = 0, submaps = 0, landmarks = 0;
  std::optional<MapScale> scale;  ///< Of the map, where there is one.
  double path_length = 0.0;       ///< Of the final trajectory, metres, or the map's unit where `scale` is not metric.
  TimeHistogram frame_times;
  std::vector<SlamStage> stages;   ///< In the order in which they first came up.
  double recording_seconds = 0.0;  ///< From the first stamp to the last one.
  double method_seconds = 0.0;     ///< In the method, reading left out.
  double peak_memory_mb = 0.0;
  std::string result_sha256;  ///< Of trajectory.txt and the files of the map.
  bool interrupted = false;
  std::string ended;  ///< "end of data", "interrupted", or the error that ended the run.

  /// How many seconds of recording the method takes in per second; nullopt where nothing was measured.
  std::optional<double> times_real_time() const;
};

std::string to_json(const SlamResult& result);

/// The numbers that a limit can name, such as "coverage".
std::vector<std::pair<std::string, double>> numbers_of(const SlamResult& result);

}  // namespace rastro
