// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/tiles.h"

#include <algorithm>

#include "rastro/synthetic/intersect.h"

namespace rastro {
namespace {

bool beside(const ViewWindow& window, const ViewedPrimitive& viewed) {
  bool left = true, right = true, above = true, below = true;
  for (const Eigen::Vector3d& corner : viewed.corners) {
    left = left && corner.x() < window.x0 * corner.z();
    right = right && corner.x() > window.x1 * corner.z();
    above = above && corner.y() < window.y0 * corner.z();
    below = below && corner.y() > window.y1 * corner.z();
  }
  return left || right || above || below;
}

}  // namespace

std::vector<ViewedPrimitive> view_primitives(const Scene& scene, const SE3& world_from_camera) {
  const SE3 camera_from_world = world_from_camera.inverse();
  std::vector<ViewedPrimitive> result;
  for (const Primitive& primitive : scene.primitives()) {
    ViewedPrimitive viewed;
    viewed.primitive = &primitive;
    viewed.origin_in_local = to_local(primitive, world_from_camera.translation() - primitive.center);
    double nearest = 1e300, farthest = -1e300;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d signs((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
      const Eigen::Vector3d local = signs.cwiseProduct(primitive.half);
      viewed.corners[corner] = camera_from_world * (primitive.center + primitive.world_from_local * local);
      nearest = std::min(nearest, viewed.corners[corner].z());
      farthest = std::max(farthest, viewed.corners[corner].z());
    }
    // A little slack for rounding of the corners against the exact intersection.
    viewed.nearest_depth = std::max(0.0, nearest - 1e-6);
    if (farthest > 0.0) result.push_back(viewed);
  }
  std::stable_sort(result.begin(), result.end(), [](const ViewedPrimitive& a, const ViewedPrimitive& b) {
    return a.nearest_depth < b.nearest_depth;
  });
  return result;
}

std::vector<const ViewedPrimitive*> seen_in(const ViewWindow& window,
                                            const std::vector<const ViewedPrimitive*>& candidates) {
  std::vector<const ViewedPrimitive*> result;
  for (const ViewedPrimitive* candidate : candidates)
    if (!beside(window, *candidate)) result.push_back(candidate);
  return result;
}

}  // namespace rastro
