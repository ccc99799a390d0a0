// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "rastro/evaluate/length_face.h"

namespace rastro {

/// Where an edge of a face is looked for, in the frame of the camera.
struct LengthEdgeSearch {
  Eigen::Vector3d spot = Eigen::Vector3d::Zero();        ///< Rough, on the edge.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< Of the edge; rough, unit length.
  Eigen::Vector3d inwards = Eigen::Vector3d::UnitY();    ///< Rough, from the edge into the face.
  double radius_m = 0.06;                                ///< How far the spot may be off.
  double half_length_m = 0.08;  ///< How much of the edge is looked at, either side of the spot.
};

/// A straight line on a face across which the grey changes, as one picture has it; frame of the camera, metres.
struct LengthEdge {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       ///< On the edge, beside the spot.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();   ///< Unit length.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of the point: of the line in the picture and of the face.
  double pixel_m = 0.0;                                  ///< Size of a pixel on the face, across the edge.
  double score = 0.0;  ///< 0 .. 2: clear changes of grey count for more, and so does a face that ends here.
  std::array<Eigen::Vector2d, 2> pixels{};  ///< Ends of what was looked at, for drawing.
};

/// The strongest such lines near the spot, best first, a handful at most; of either sign of change. None where the
/// picture does not show the spot or is too coarse there. What depth says of a line counts only where the face has
/// support.
std::vector<LengthEdge> find_edges(const LengthView& view, const LengthFace& face, const LengthEdgeSearch& search);

}  // namespace rastro
