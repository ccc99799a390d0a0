// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_odometry.h"

#include <fmt/format.h>

#include <utility>

#include "rastro/cli/loss_advice.h"
#include "rastro/viewer/run_record.h"

namespace rastro::cli {
namespace {

LiveFrame live_frame(const OdometryUpdate& update) {
  LiveFrame live;
  live.index = update.index;
  live.stamp_s = to_seconds(update.stamp);
  live.state = scene_state_of(name_of(update.state));
  if (update.reason != OdometryReason::none) live.reason = name_of(update.reason);
  live.detail = update.detail;
  live.advice = advice_for(update.reason);
  if (update.state != OdometryState::initializing) live.world_from_body = update.world_from_camera;
  live.used = update.inliers;
  live.score = update.confidence;
  live.milliseconds = update.milliseconds;
  return live;
}

/// The states in the order of OdometryFeature::State.
LiveFeatures live_features(const std::vector<OdometryFeature>& seen) {
  LiveFeatures features;
  features.state_names = {"matched", "outlier", "inlier", "new"};
  for (const OdometryFeature& feature : seen) {
    features.pixels.insert(features.pixels.end(), {feature.pixel.x(), feature.pixel.y()});
    features.states.push_back(static_cast<std::uint8_t>(feature.state));
    features.ids.push_back(static_cast<std::int32_t>(feature.id));
  }
  return features;
}

}  // namespace

LiveOdometry::LiveOdometry(const ServerFlags& flags, const LiveHello& run, const Odometry& method)
    : method_(method), sink_(flags, run) {
  scene_.title = run.title;
  scene_.method = run.method;
  sink_.view().show(scene_);  // tells the page which way is up
}

void LiveOdometry::show(const Frame& frame, const OdometryUpdate& update) {
  ++done_;
  if (sink_.is_watched()) {
    LiveFrame live = live_frame(update);
    live.done = done_;
    sink_.show(std::move(live));
    show_image(frame);
  }
  sink_.obey_pages();
}

void LiveOdometry::show_image(const Frame& frame) {
  LiveFeatures features = live_features(method_.features());
  trails_.add(features);
  if (frame.image.empty() || !sink_.view().wants_image()) return;
  SeenImage seen;
  seen.frame.index = frame.index;
  seen.frame.stamp = frame.stamp;
  seen.frame.image = frame.image;
  trails_.write_to(features);
  seen.features = std::move(features);
  sink_.view().show(std::move(seen));
}

void LiveOdometry::finish(const OdometryRunEnd& end) {
  RunRecord record;
  record.trajectory = end.trajectory;
  ++scene_.revision;
  add_run(record, scene_);
  sink_.view().show(scene_);
  sink_.finish(fmt::format("{} frames, {} tracked, {} lost; path {:.2f} (scale: {})", end.result.frames,
                           end.result.tracking, end.result.lost, end.result.path_length, end.result.scale));
}

}  // namespace rastro::cli
