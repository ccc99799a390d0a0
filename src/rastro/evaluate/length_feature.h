// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "rastro/evaluate/length_face.h"
#include "rastro/evaluate/length_objects.h"
#include "rastro/evaluate/map_lengths.h"

namespace rastro {

/// A straight edge to detect, or a face if there is none; world frame.
struct LengthFeature {
  Eigen::Vector3d spot;
  Eigen::Vector3d along;    ///< Unit; of the edge, or any direction in the face.
  Eigen::Vector3d inwards;  ///< Unit, perpendicular to `along`: from the edge into the face.
  bool is_edge = false;
  bool normal_known = false;
  double reach_m = 0.0;  ///< Known extent of the face inwards.

  Eigen::Vector3d normal() const { return along.cross(inwards); }
};

/// The feature at one end of a length: an edge, a face, or the two edges of a corner.
std::vector<LengthFeature> length_features(const LengthObject& object, const LengthPoint& spot,
                                           const MapLengthOptions& options);

/// Search region of a feature's face, in the frame of the feature.
LengthRegion length_region(const LengthFeature& feature, double radius_m, const MapLengthOptions& options);

/// Result before any measurement; `why` it cannot be measured.
MeasuredLength not_measured(const LengthObject& object, const std::string& why);

}  // namespace rastro
