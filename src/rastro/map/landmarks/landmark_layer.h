// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/feature/brief.h"
#include "rastro/map/layer_type.h"

namespace rastro {

/// A feature of a keyframe that shows a landmark.
struct LandmarkObservation {
  KeyframeId keyframe = 0;
  std::uint32_t feature = 0;  ///< Index in its features.
  bool operator==(const LandmarkObservation&) const = default;
};

/// A point of the world.
struct Landmark {
  std::int64_t id = 0;  ///< Running number, in the order of creation; culled ones leave gaps.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();   ///< In the frame of its submap, the map's unit.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< Mean viewing direction from cameras to it, length 1.
  Descriptor descriptor;                                ///< The one nearest to all others of its observations.
  float min_distance = 0.0F, max_distance = 0.0F;       ///< From which it can be recognized.
  std::vector<LandmarkObservation> observations;        ///< By keyframe.
};

/// What a filter knows of a landmark, whose observations it does not keep.
struct LandmarkEstimate {
  std::int64_t sensor_id = -1;                               ///< As the sensor names it; -1: not at all.
  int observations = 0;                                      ///< How many it rests on.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< Of the position, the map's unit squared.
};

/// The landmarks of a map. Landmarks of a filter have estimates, one each, and no observations.
struct LandmarkLayer : Layer {
  static constexpr const char* layer_name = "landmarks";
  std::vector<Landmark> landmarks;  ///< Ids ascend.
  std::vector<LandmarkEstimate> estimates;

  const Landmark* find(std::int64_t id) const;  ///< Null where there is none.
};

/// The submap that a landmark belongs to: that of the first keyframe that observes it; 0 without observations.
int submap_of(const Map& map, const Landmark& landmark);

std::unique_ptr<LayerType> landmarks_layer_type();

}  // namespace rastro
