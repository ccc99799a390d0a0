// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/feature/brief.h"
#include "rastro/map/layer_type.h"

namespace rastro {

/// A feature of a keyframe that observes a landmark.
struct LandmarkObservation {
  KeyframeId keyframe = 0;
  std::uint32_t feature = 0;  ///< Index in its features.
  bool operator==(const LandmarkObservation&) const = default;
};

/// A 3D point of the map.
struct Landmark {
  std::int64_t id = 0;  ///< Running number, in the order of creation; culled ones leave gaps.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();   ///< In the frame of its submap, the map's unit.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< Mean viewing direction from cameras to it, length 1.
  Descriptor descriptor;                                ///< The one closest to those of all its observations.
  float min_distance = 0.0F, max_distance = 0.0F;       ///< Range in which it can be recognized.
  std::vector<LandmarkObservation> observations;        ///< By keyframe.
};

/// A filter's estimate of a landmark, whose observations it does not keep.
struct LandmarkEstimate {
  std::int64_t sensor_id = -1;                               ///< The sensor's id of it; -1: none.
  int observations = 0;                                      ///< Number of observations used.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< Of the position, the map's unit squared.
};

/// The landmarks of a map. Landmarks of a filter have one estimate each and no observations.
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
