// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/odometry/rgbd_tracking/coverage.h"
#include "rastro/odometry/rgbd_tracking/options.h"
#include "rastro/odometry/rgbd_tracking/point_map.h"
#include "rastro/odometry/rgbd_tracking/pose_solver.h"
#include "rastro/registration/projective_icp.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// How well a frame's surfaces match those of the reference frames.
struct SurfaceMatch {
  int compared = 0;  ///< Blocks of depth that project onto a surface; a coarse search counts for those it skips.
  int fitting = 0;   ///< Of these, within the noise.

  /// Enough for surfaces alone to determine a pose.
  bool fits() const { return compared >= least_compared && 2 * fitting >= compared; }
  static constexpr int least_compared = 1500;
};

/// Aligns the surfaces of frames with those of a map's reference frames.
class SurfaceMatcher {
 public:
  explicit SurfaceMatcher(const RgbdOptions& options) : options_(options) {}

  /// Sets the next frame. Its surfaces are computed on demand. `camera`: with its size.
  void take(const Frame& frame, const Camera& camera);
  /// Leaves out parts of the frame, because something moves there.
  void leave_out(const ImageParts& moving);
  bool has_surfaces() const { return !blocks_.empty(); }
  /// Chooses the map's reference frames to compare with: the one of largest overlap, and the oldest of sufficient
  /// overlap, which keeps drift small.
  void choose(const PointMap& map, const SE3& pose, const SE3& camera_from_depth);
  /// Cost against the chosen references; depth was taken at `camera_from_depth` from the instant of the color image.
  /// Weighted by the option, because errors of adjacent blocks are correlated.
  PoseQuadratic compare(const PointMap& map, const SE3& pose, const SE3& camera_from_depth, double reach_m, int step,
                        SurfaceMatch* match = nullptr) const;
  /// The same with the delay of depth as an unknown; `velocity`: of the camera, per second.
  DelayedQuadratic compare_with_delay(const PointMap& map, const SE3& pose, const SE3& camera_from_depth,
                                      const Vector6d& velocity, double reach_m, int step) const;
  /// The frame's surfaces as those of a reference frame.
  void keep(Reference& reference, const SE3& camera_from_depth, const Vector6d& velocity) const;

 private:
  SurfaceFit fit_to(const Reference& reference, const SE3& pose, const SE3& camera_from_depth, double reach_m,
                    int step) const;

  const RgbdOptions& options_;
  std::optional<ProjectiveIcp> icp_;
  SurfaceOptions surface_options_;
  DepthBlocks blocks_;
  std::vector<int> chosen_;  ///< Indices of reference frames.
};

}  // namespace rastro
