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
#include "rastro/session/live_input.h"
#include "rastro/session/run_folder.h"
#include "rastro/session/run_result.h"
#include "rastro/track/track_sink.h"

namespace rastro {

/// Progress of the run, after each frame.
struct TrackProgress {
  std::int64_t done = 0;               ///< Frames processed or skipped.
  std::optional<std::int64_t> frames;  ///< Total number of frames, if known.
  const TrackFrame* last = nullptr;    ///< The frame just processed.
  double ms_per_frame_mean = 0.0;
};

/// The parts of one run. They must outlive track_run().
struct TrackRun {
  Source* source = nullptr;
  LiveInput* live = nullptr;  ///< `source` in a live run, else null.
  /// Tracker::process, or a stand-in for it.
  std::function<TrackFrame(GrayView image, TimeNs stamp, GrayView mask)> process;
  /// The mask of a frame, empty for none; valid until the next call. May be unset.
  std::function<GrayView(const Frame&)> mask_of;
  std::vector<TrackSink*> sinks;            ///< Called after each frame, in the caller's thread.
  std::vector<TrackSink*> image_sinks;      ///< Slow ones, called in a thread of their own.
  RunFolder* folder = nullptr;              ///< May be null: no stats, no events.
  const std::atomic<bool>* stop = nullptr;  ///< Set from outside (Ctrl-C): the run ends after the current frame.
  std::optional<std::int64_t> frames_asked;
  std::function<void(const TrackProgress&)> progress;
};

/// How the run ended. `failure` is the error that ended it early; everything before it is counted and written.
struct TrackRunEnd {
  TrackResult result;  ///< Without the two hashes.
  std::exception_ptr failure;
  std::string first_skip;  ///< Why the first skipped frame could not be read; empty when none was skipped.
};

/// Runs the tracker over the source and passes its frames to the sinks, in constant memory. Frames are numbered as in
/// the recording. Frames that cannot be read are skipped, counted and reported as events.
TrackRunEnd track_run(const TrackRun& run);

}  // namespace rastro
