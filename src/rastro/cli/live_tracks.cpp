// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_tracks.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "rastro/cli/loss_advice.h"

namespace rastro::cli {
namespace {

std::vector<std::pair<std::string, double>> stages_of(const TrackTimes& times) {
  return {{"pyramid", times.pyramid_ms}, {"flow", times.flow_ms},        {"outliers", times.outlier_ms},
          {"predict", times.predict_ms}, {"detect", times.detect_ms},    {"describe", times.describe_ms},
          {"match", times.match_ms},     {"validate", times.validate_ms}};
}

LiveFrame live_frame(const TrackFrame& frame) {
  LiveFrame live;
  live.index = frame.index;
  live.stamp_s = to_seconds(frame.stamp);
  const bool good = frame.health == TrackHealth::good;
  live.state = scene_state_of(good ? "tracking" : "weak");
  if (!good) live.reason = name_of(frame.health);
  live.advice = advice_for(frame.health);
  live.detail = fmt::format("{} new, {} re-identified, {} lost", frame.fresh, frame.reidentified, frame.lost);
  live.used = frame.tracked;
  live.score = std::numeric_limits<double>::quiet_NaN();  // it has none
  live.milliseconds = frame.times.total_ms;
  live.stages = stages_of(frame.times);
  return live;
}

GrayImage copy_of_view(GrayView view) {
  GrayImage image(view.width, view.height);
  for (int y = 0; y < view.height; ++y) std::copy_n(view.row(y), view.width, image.row(y));
  return image;
}

LiveHello without_poses(LiveHello run) {
  run.has_poses = false;
  return run;
}

}  // namespace

LiveFeatures live_features(const TrackFrame& frame) {
  LiveFeatures features;
  features.state_names = {"matched", "new", "re_identified"};
  for (const TrackedFeature& feature : frame.features) {
    features.pixels.insert(features.pixels.end(), {feature.pixel.x(), feature.pixel.y()});
    features.states.push_back(static_cast<std::uint8_t>(feature.state));
    features.ids.push_back(static_cast<std::int32_t>(feature.id));
  }
  return features;
}

LiveTracks::LiveTracks(const ServerFlags& flags, LiveHello run) : sink_(flags, without_poses(std::move(run))) {}

void LiveTracks::write(const TrackFrame& frame, GrayView image) {
  ++done_;
  if (sink_.is_watched()) {
    LiveFrame live = live_frame(frame);
    live.done = done_;
    sink_.show(std::move(live));
    LiveFeatures features = live_features(frame);
    trails_.add(features);
    if (sink_.view().wants_image()) show_image(std::move(features), frame, image);
  }
  sink_.obey_pages();
}

void LiveTracks::show_image(LiveFeatures features, const TrackFrame& frame, GrayView image) {
  SeenImage seen;
  seen.frame.index = frame.index;
  seen.frame.stamp = frame.stamp;
  seen.frame.image = copy_of_view(image);
  trails_.write_to(features);
  seen.features = std::move(features);
  sink_.view().show(std::move(seen));
}

void LiveTracks::finish(const TrackRunEnd& end) {
  sink_.finish(fmt::format("{} frames, {} tracks of {:.1f} frames on average, {} re-identified", end.result.frames,
                           end.result.features, end.result.mean_track_length, end.result.reidentified));
}

}  // namespace rastro::cli
