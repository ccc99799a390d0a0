// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "rastro/evaluate/length_face.h"

namespace rastro {

/// Search region of an edge of a face, in the camera frame.
struct LengthEdgeSearch {
  Eigen::Vector3d spot = Eigen::Vector3d::Zero();        ///< Rough, on the edge.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< Of the edge; rough, unit length.
  Eigen::Vector3d inwards = Eigen::Vector3d::UnitY();    ///< Rough, from the edge into the face.
  double radius_m = 0.06;                                ///< Search radius around the rough point.
  double half_length_m = 0.08;  ///< Length of the edge used, on either side of the rough point.
};

/// A straight line of intensity change on a face, in one image; camera frame, meters.
struct LengthEdge {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();      ///< On the edge, next to the rough point.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< Unit length.
  /// Of the point: from the line in the image and from the face.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double pixel_m = 0.0;  ///< Size of a pixel on the face, across the edge.
  double score = 0.0;    ///< 0 .. 2: higher for a clear intensity change and for a face that ends here.
  std::array<Eigen::Vector2d, 2> pixels{};  ///< Ends of the used part, for drawing.
};

/// The strongest lines near the rough point, best first, a handful at most; with either sign of change. None if the
/// image does not show the point or is too coarse there. Depth affects a line's score only where the face has support.
std::vector<LengthEdge> find_edges(const LengthView& view, const LengthFace& face, const LengthEdgeSearch& search);

}  // namespace rastro
