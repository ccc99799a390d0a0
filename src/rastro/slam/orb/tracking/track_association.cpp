// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/track_association.h"

#include <algorithm>

namespace rastro {
namespace {

TrackOptions track_options(const OrbSlamOptions& options) {
  TrackOptions tracks;
  tracks.features = options.tracks;
  tracks.min_distance_px = options.tracks_distance_px;
  tracks.seed = options.seed;
  return tracks;
}

}  // namespace

TrackAssociation::TrackAssociation(const OrbSlamOptions& options, const Camera& camera, TaskPool* pool)
    : options_(options), camera_(camera), tracker_(track_options(options), camera, pool) {}

std::vector<LandmarkTrack> TrackAssociation::follow(const Frame& frame) {
  std::vector<LandmarkTrack> followed;
  if (width_ == 0) width_ = frame.image.width(), height_ = frame.image.height();
  if (frame.image.width() != width_ || frame.image.height() != height_) return followed;
  last_ = tracker_.process(frame.image.view(), frame.stamp, frame.mask.view());
  for (const TrackedFeature& feature : last_.features) {
    const auto known = landmark_of_track_.find(feature.id);
    if (known == landmark_of_track_.end() || !feature.ray.allFinite()) continue;
    followed.push_back({known->second, feature.ray.cast<double>()});
  }
  std::stable_sort(followed.begin(), followed.end(),
                   [](const LandmarkTrack& a, const LandmarkTrack& b) { return a.landmark < b.landmark; });
  return followed;
}

void TrackAssociation::learn(const FeatureFrame& frame, const std::vector<TrackedPoint>& points) {
  std::vector<std::int64_t> landmarks(frame.size(), -1);
  for (const TrackedPoint& point : points) landmarks[point.feature] = point.landmark;
  std::vector<std::uint32_t> near;
  for (const TrackedFeature& feature : last_.features) {
    const auto x = static_cast<float>(camera_.fx) * feature.ray.x() + static_cast<float>(camera_.cx);
    const auto y = static_cast<float>(camera_.fy) * feature.ray.y() + static_cast<float>(camera_.cy);
    frame.grid().find(x, y, static_cast<float>(options_.tracks_near_px), 0, options_.levels - 1, near);
    float least = static_cast<float>(options_.tracks_near_px);
    for (const std::uint32_t i : near) {
      const float distance = (frame.pixel(i) - Eigen::Vector2f(x, y)).norm();
      if (landmarks[i] < 0 || distance >= least) continue;
      least = distance;
      landmark_of_track_[feature.id] = landmarks[i];
    }
  }
  // A track that may still reappear was last observed within the window.
  const std::int64_t oldest = last_.features.empty() ? 0 : last_.features.back().id - options_.tracks_kept;
  landmark_of_track_.erase(landmark_of_track_.begin(), landmark_of_track_.lower_bound(oldest));
}

}  // namespace rastro
