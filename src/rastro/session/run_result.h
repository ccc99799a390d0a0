// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/session/live_statistics.h"

namespace rastro {

/// The result of a tracking run; the fields of its result.json. Percentages are 0 to 100.
struct TrackResult {
  std::int64_t frames = 0;          ///< Processed.
  std::int64_t skipped_frames = 0;  ///< Could not be read.
  double coverage = 0.0;            ///< Processed frames in percent of the frames asked for.
  double ms_per_frame_mean = 0.0;   ///< Of the tracker alone, without reading and writing.
  double ms_per_frame_p95 = 0.0;
  double peak_memory_mb = 0.0;
  std::optional<LiveStatistics> live;  ///< Of a live run.
  std::string result_sha256;           ///< Of the bytes of tracks.csv.
  std::string options_sha256;          ///< Of the values in force.
  std::int64_t features = 0;           ///< Number of ids.
  std::int64_t observations = 0;
  std::int64_t tracked = 0;
  std::int64_t reidentified = 0;
  std::int64_t lost = 0;
  std::int64_t masked = 0;
  double mean_track_length = 0.0;     ///< Mean number of frames in which an id was observed.
  std::int64_t unhealthy_frames = 0;  ///< Frames with fewer features than asked for, or with abrupt motion.
  bool interrupted = false;
  std::string ended;  ///< "end of data", "interrupted", or the error that ended the run.
};

std::string to_json(const TrackResult& result);

/// The numbers of a result by their names in result.json, for limits.
std::vector<std::pair<std::string, double>> numbers_of(const TrackResult& result);

/// A limit such as "coverage>=95" on a number of the result; operators >= <= > <.
class Limit {
 public:
  /// Error for an unknown name (with the nearest known one) or a text that is no limit.
  explicit Limit(const std::string& text);
  bool kept_by(const TrackResult& result) const;
  /// "coverage>=95 missed: it is 90.5".
  std::string complaint(const TrackResult& result) const;

 private:
  double value_in(const TrackResult& result) const;
  std::string text_, name_, comparison_;
  double bound_ = 0.0;
};

}  // namespace rastro
