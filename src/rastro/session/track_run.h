// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "rastro/sensor/source.h"
#include "rastro/session/run_folder.h"
#include "rastro/session/run_result.h"
#include "rastro/track/track_sink.h"

namespace rastro {

/// Where the run stands, after each frame.
struct TrackProgress {
  std::int64_t done = 0;               ///< Frames processed or skipped.
  std::optional<std::int64_t> frames;  ///< Of how many, where that is known.
  const TrackFrame* last = nullptr;    ///< The frame just processed.
  double ms_per_frame_mean = 0.0;
};

/// Everything one run is made of. The parts must outlive track_run().
struct TrackRun {
  Source* source = nullptr;
  /// Tracker::process, or a stand-in for it.
  std::function<TrackFrame(GreyView image, TimeNs stamp, GreyView mask)> process;
  /// The mask of a frame, empty for none; valid until the next call. May be unset.
  std::function<GreyView(const Frame&)> mask_of;
  std::vector<TrackSink*> sinks;            ///< Called after each frame, in the caller's thread.
  std::vector<TrackSink*> picture_sinks;    ///< Slow ones, called on a thread of their own.
  RunFolder* folder = nullptr;              ///< May be null: no stats, no events.
  const std::atomic<bool>* stop = nullptr;  ///< Set from outside (Ctrl-C): the run ends after the current frame.
  std::optional<std::int64_t> frames_asked;
  std::function<void(const TrackProgress&)> progress;
};

/// How it ended. `failure` holds the error that ended a run early; all before it is counted and written.
struct TrackRunEnd {
  TrackResult result;  ///< Without the two hashes.
  std::exception_ptr failure;
  std::string first_skip;  ///< Why the first skipped frame could not be read; empty when none was skipped.
};

/// Runs the tracker over the source and its frames through the sinks, in memory that does not grow with the run. Frames
/// are numbered as in the recording. Frames that cannot be read are skipped, counted and reported as events.
TrackRunEnd track_run(const TrackRun& run);

}  // namespace rastro
