// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "rastro/export/feature_text.h"
#include "rastro/track/track_sink.h"

namespace rastro {

inline TrackedFeature make_feature(std::int64_t id, TrackState state, float x = 10.5F, float y = 20.25F) {
  TrackedFeature feature;
  feature.id = id;
  feature.pixel = {x, y};
  feature.ray = {0.1F * x, 1e-6F * y};
  feature.state = state;
  feature.age = state == TrackState::fresh ? 1 : 3;
  feature.last_seen = state == TrackState::fresh ? -1 : 0;
  return feature;
}

inline TrackFrame make_frame(std::int64_t index, const std::vector<TrackedFeature>& features) {
  TrackFrame frame;
  frame.index = index;
  frame.stamp = 1403636579763555584 + 50'000'000 * index;
  for (const TrackedFeature& feature : features) add_feature(frame, feature);
  return frame;
}

/// Three frames with all that a file can hold: every state, a missing ray, an empty frame, awkward numbers.
inline std::vector<TrackFrame> awkward_frames() {
  using enum TrackState;
  std::vector<TrackFrame> frames;
  frames.push_back(
      make_frame(0, {make_feature(0, fresh), make_feature(1, fresh, 0.0F, 1e-7F), make_feature(7, fresh)}));
  frames.back().features[1].ray = Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
  frames.push_back(make_frame(3, {}));
  frames.back().lost = 3;
  frames.back().health = TrackHealth::dark_or_blank;
  frames.push_back(
      make_frame(4, {make_feature(1, reidentified, -0.5F, 479.9999F), make_feature(7, tracked, 1.0F / 3.0F),
                     make_feature(123456789, fresh, 1e4F, 123.456789F)}));
  frames.back().masked = 12;
  frames.back().health = TrackHealth::abrupt_motion;
  return frames;
}

inline bool same_float(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

inline bool same_feature(const TrackedFeature& a, const TrackedFeature& b) {
  return a.id == b.id && a.pixel == b.pixel && same_float(a.ray.x(), b.ray.x()) && same_float(a.ray.y(), b.ray.y()) &&
         a.age == b.age && a.state == b.state && a.last_seen == b.last_seen;
}

/// Everything but the times, which no track file holds.
inline bool same_frame(const TrackFrame& a, const TrackFrame& b) {
  if (a.features.size() != b.features.size()) return false;
  for (std::size_t i = 0; i < a.features.size(); ++i) {
    if (!same_feature(a.features[i], b.features[i])) return false;
  }
  return a.index == b.index && a.stamp == b.stamp && a.tracked == b.tracked && a.reidentified == b.reidentified &&
         a.fresh == b.fresh && a.lost == b.lost && a.masked == b.masked && a.health == b.health;
}

}  // namespace rastro
