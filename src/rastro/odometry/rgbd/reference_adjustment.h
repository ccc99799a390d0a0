// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {

/// A point on a ray of one camera of a window, with what was read of its inverse depth there.
struct AnchoredPoint {
  int camera = 0;
  Eigen::Vector2d ray;         ///< Normalised.
  double inverse_depth = 1.0;  ///< 1/m, in the anchor's camera.
  double read_inverse_depth = 1.0;
  double information = 0.0;  ///< Of the reading, m^2.
};

/// A point seen by another camera of the window.
struct AnchoredSighting {
  int camera = 0;
  int point = 0;
  Eigen::Vector2d ray;               ///< Normalised.
  double inverse_depth = 0.0;        ///< Read there, 1/m; 0 = not.
  double inverse_depth_sigma = 1.0;  ///< Of it, 1/m.
};

/// What is known of two cameras beside the points: surfaces that fit.
struct CameraLink {
  int from = 0, to = 0;
  SE3 from_from_to;
  Matrix6d information;  ///< Of d in truth = from_from_to * exp(d).
};

struct ReferenceWindow {
  std::vector<SE3> world_from_camera;
  std::vector<char> fixed;  ///< Cameras that stay; at least one.
  std::vector<AnchoredPoint> points;
  std::vector<AnchoredSighting> sightings;  ///< Those of one point stand together, points in order.
  std::vector<CameraLink> links;
  double ray_sigma = 0.002;
};

/// Adjusts the free cameras and all inverse depths together: Levenberg-Marquardt with the depths eliminated, which are
/// one number a point as it stays on its anchor's ray. Far errors count less (Cauchy). Returns the cost before and
/// after in squared standard deviations. The same input gives the same bytes.
std::pair<double, double> adjust_references(ReferenceWindow& window, int iterations);

}  // namespace rastro
