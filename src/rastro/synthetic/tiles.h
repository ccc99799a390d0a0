// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "rastro/math/se3.h"
#include "rastro/synthetic/scene.h"

namespace rastro {

/// A solid in the view of one camera pose.
struct ViewedPrimitive {
  const Primitive* primitive = nullptr;
  Eigen::Vector3d origin_in_local;  ///< The camera's center.
  double nearest_depth = 0.0;       ///< Lower bound of its depth along the optical axis.
  Eigen::Vector3d corners[8];       ///< Of its oriented box, in the camera.
};

/// A viewing frustum in normalized image coordinates.
struct ViewWindow {
  double x0, y0, x1, y1;
};

/// Solids in front of the camera, nearest first.
std::vector<ViewedPrimitive> view_primitives(const Scene& scene, const SE3& world_from_camera);

/// Those of `candidates` that may be visible in the window, in the same order. Never drops a visible one.
std::vector<const ViewedPrimitive*> seen_in(const ViewWindow& window,
                                            const std::vector<const ViewedPrimitive*>& candidates);

}  // namespace rastro
