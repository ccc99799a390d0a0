// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "rastro/evaluate/length_face.h"
#include "rastro/evaluate/length_objects.h"
#include "rastro/evaluate/map_lengths.h"

namespace rastro {

/// A straight edge to look for, or a face where there is none; world.
struct LengthFeature {
  Eigen::Vector3d spot;
  Eigen::Vector3d along;    ///< Unit; of the edge, or any direction in the face.
  Eigen::Vector3d inwards;  ///< Unit, at right angles to `along`: from the edge into the face.
  bool is_edge = false;
  bool normal_known = false;
  double reach_m = 0.0;  ///< How far the face is known to go inwards.

  Eigen::Vector3d normal() const { return along.cross(inwards); }
};

/// What is looked for at one end of a length: an edge, a face, or the two edges of a corner.
std::vector<LengthFeature> length_features(const LengthObject& object, const LengthSpot& spot,
                                           const MapLengthOptions& options);

/// Where the face of a feature is looked for, in the frame of the feature.
LengthRegion length_region(const LengthFeature& feature, double radius_m, const MapLengthOptions& options);

/// What is known before anything is measured; `why` it cannot be.
MeasuredLength not_measured(const LengthObject& object, const std::string& why);

}  // namespace rastro
