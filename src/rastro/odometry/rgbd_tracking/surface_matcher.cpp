// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/surface_matcher.h"

#include <algorithm>

namespace rastro {
namespace {

// Beyond this distance a block belongs to another surface.
constexpr double overlap_reach_m = 0.1;
constexpr double least_overlap = 0.3;
// A reference with this share of the largest overlap is as good, and an older one is better.
constexpr double good_overlap = 0.7;

}  // namespace

void SurfaceMatcher::take(const Frame& frame, const Camera& camera) {
  chosen_.clear();
  blocks_ = {};
  if (options_.surfaces == "off" || frame.depth.empty() || frame.depth.width() != camera.width ||
      frame.depth.height() != camera.height)
    return;
  if (!icp_) {
    surface_options_ = {options_.depth_sigma_m, options_.depth_sigma_per_m2, options_.min_depth_m,
                        options_.max_depth_m};
    icp_.emplace(camera, surface_options_);
  }
  blocks_ = depth_blocks(frame.depth, frame.mask.view(), surface_options_);
}

void SurfaceMatcher::leave_out(const ImageParts& moving) {
  for (int y = 0; y < blocks_.height; ++y) {
    for (int x = 0; x < blocks_.width; ++x) {
      if (moving.at(x * surface_block_px, y * surface_block_px))
        blocks_.depth[static_cast<std::size_t>(y * blocks_.width + x)] = 0.0F;
    }
  }
}

void SurfaceMatcher::choose(const PointMap& map, const SE3& pose, const SE3& camera_from_depth) {
  chosen_.clear();
  if (!has_surfaces()) return;
  int best = -1, oldest = -1;
  double most = least_overlap;
  for (std::size_t i = static_cast<std::size_t>(map.first_live); i < map.references.size(); ++i) {
    const Reference& reference = map.references[i];
    if (reference.planes.empty()) continue;
    const SE3 world_from_depth = reference.world_from_camera * reference.camera_from_depth;
    const double share = icp_->overlap(reference.planes, blocks_, world_from_depth.inverse() * pose * camera_from_depth,
                                       overlap_reach_m);
    if (share > good_overlap && oldest < 0) oldest = static_cast<int>(i);
    if (share >= most) {
      most = share;
      best = static_cast<int>(i);
    }
  }
  if (best >= 0) chosen_.push_back(best);
  if (oldest >= 0 && oldest != best) chosen_.push_back(oldest);
}

SurfaceFit SurfaceMatcher::fit_to(const Reference& reference, const SE3& pose, const SE3& camera_from_depth,
                                  double reach_m, int step) const {
  const SE3 reference_from_blocks =
      (reference.world_from_camera * reference.camera_from_depth).inverse() * pose * camera_from_depth;
  SurfaceFit fit = icp_->compare(reference.planes, blocks_, reference_from_blocks, reach_m, step);
  // pose * exp(d) * camera_from_depth = pose * camera_from_depth * exp(Ad d)
  const Matrix6d adjoint = camera_from_depth.inverse().adjoint();
  fit.information = adjoint.transpose() * fit.information * adjoint;
  fit.gradient = adjoint.transpose() * fit.gradient;
  return fit;
}

PoseQuadratic SurfaceMatcher::compare(const PointMap& map, const SE3& pose, const SE3& camera_from_depth,
                                      double reach_m, int step, SurfaceMatch* match) const {
  PoseQuadratic sum;
  for (const int number : chosen_) {
    const SurfaceFit fit =
        fit_to(map.references[static_cast<std::size_t>(number)], pose, camera_from_depth, reach_m, step);
    // As many blocks as a full comparison would have had.
    const double weight = options_.surface_weight * step * step;
    sum.information += weight * fit.information;
    sum.gradient += weight * fit.gradient;
    if (!match) continue;
    match->compared += step * step * fit.compared;
    match->fitting += step * step * fit.fitting;
  }
  return sum;
}

DelayedQuadratic SurfaceMatcher::compare_with_delay(const PointMap& map, const SE3& pose, const SE3& camera_from_depth,
                                                    const Vector6d& velocity, double reach_m, int step) const {
  DelayedQuadratic sum;
  for (const int number : chosen_) {
    const Reference& reference = map.references[static_cast<std::size_t>(number)];
    const SurfaceFit fit = fit_to(reference, pose, camera_from_depth, reach_m, step);
    const double weight = options_.surface_weight * step * step;
    // Later, the frame's camera has moved on, and so has the reference's.
    const Vector6d moved = velocity - (pose.inverse() * reference.world_from_camera).adjoint() * reference.velocity;
    const Vector6d cross = fit.information * moved;
    sum.information.topLeftCorner<6, 6>() += weight * fit.information;
    sum.information.topRightCorner<6, 1>() += weight * cross;
    sum.information.bottomLeftCorner<1, 6>() += weight * cross.transpose();
    sum.information(6, 6) += weight * moved.dot(cross);
    sum.gradient.head<6>() += weight * fit.gradient;
    sum.gradient(6) += weight * moved.dot(fit.gradient);
  }
  return sum;
}

void SurfaceMatcher::keep(Reference& reference, const SE3& camera_from_depth, const Vector6d& velocity) const {
  reference.velocity = velocity;
  if (!has_surfaces()) return;
  reference.planes = icp_->planes(blocks_);
  reference.camera_from_depth = camera_from_depth;
}

}  // namespace rastro
