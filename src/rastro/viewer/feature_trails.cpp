// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/feature_trails.h"

namespace rastro {

void FeatureTrails::add(const LiveFeatures& features) {
  ++frame_;
  for (std::size_t row = 0; row < features.ids.size(); ++row) {
    if (features.ids[row] < 0) continue;
    Trail& trail = trails_[features.ids[row]];
    trail.pixels.push_back({features.pixels[2 * row], features.pixels[2 * row + 1]});
    if (trail.pixels.size() > longest) trail.pixels.pop_front();
    trail.frame = frame_;
  }
  std::erase_if(trails_, [this](const auto& each) { return each.second.frame + most_missing < frame_; });
}

void FeatureTrails::write_to(LiveFeatures& features) const {
  features.trail_lengths.assign(features.ids.size(), 0);
  features.trails.clear();
  for (std::size_t row = 0; row < features.ids.size(); ++row) {
    const auto found = trails_.find(features.ids[row]);
    if (found == trails_.end()) continue;
    features.trail_lengths[row] = static_cast<std::uint8_t>(found->second.pixels.size());
    for (const auto& pixel : found->second.pixels)
      features.trails.insert(features.trails.end(), pixel.begin(), pixel.end());
  }
}

}  // namespace rastro
