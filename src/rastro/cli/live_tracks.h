// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/cli/live_sink.h"
#include "rastro/session/track_run.h"
#include "rastro/track/track_sink.h"
#include "rastro/viewer/feature_trails.h"

namespace rastro::cli {

/// The features of a frame as the page draws them, the states in the order of TrackState.
LiveFeatures live_features(const TrackFrame& frame);

/// --view of `rastro track`: each image with its features, and where they were in the frames before.
class LiveTracks : public TrackSink {
 public:
  LiveTracks(const ServerFlags& flags, LiveHello run);

  /// Waits while the page has paused the run.
  void write(const TrackFrame& frame, GrayView image) override;
  /// The result of the run, after it.
  void finish(const TrackRunEnd& end);
  using TrackSink::finish;
  void wait_until_closed() { sink_.wait_until_closed(); }
  /// While a live source gives no frame.
  void idle(const std::string& line) { sink_.idle(line); }

 private:
  void show_image(LiveFeatures features, const TrackFrame& frame, GrayView image);

  std::int64_t done_ = 0;
  FeatureTrails trails_;
  LiveSink sink_;
};

}  // namespace rastro::cli
