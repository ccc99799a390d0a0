// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"

namespace rastro {

/// Which keyframes and landmarks belong to the submap that is asked for; -1: all.
class LandmarkPart {
 public:
  LandmarkPart(const Map& map, int submap)
      : map_(map), landmarks_(map.layer<LandmarkLayer>()), features_(map.layer<FeatureLayer>()), submap_(submap) {}

  /// None of a map without landmarks.
  const std::vector<Landmark>& landmarks() const {
    static const std::vector<Landmark> none;
    return landmarks_ ? landmarks_->landmarks : none;
  }
  bool has_keyframe(std::size_t index) const { return submap_ < 0 || map_.keyframes[index].submap == submap_; }
  std::optional<std::size_t> index_of(KeyframeId id) const {
    const auto index = map_.index_of(id);
    return index && has_keyframe(*index) ? index : std::nullopt;
  }
  /// The first observation by a keyframe of the part; null where there is none.
  const LandmarkObservation* first_observation(const Landmark& landmark) const {
    for (const LandmarkObservation& observation : landmark.observations)
      if (index_of(observation.keyframe)) return &observation;
    return nullptr;
  }
  /// Null where the map has none of this keyframe.
  const ImageFeatures* features_of(KeyframeId id) const { return features_ ? features_->find(id) : nullptr; }
  /// Where the image of a keyframe shows an observation; null where the map does not know.
  const Keypoint* keypoint_of(const LandmarkObservation& observation) const {
    const ImageFeatures* image = features_of(observation.keyframe);
    return image && observation.feature < image->features.size() ? &image->features.keypoints[observation.feature]
                                                                 : nullptr;
  }

 private:
  const Map& map_;
  std::shared_ptr<const LandmarkLayer> landmarks_;
  std::shared_ptr<const FeatureLayer> features_;
  int submap_;
};

}  // namespace rastro
