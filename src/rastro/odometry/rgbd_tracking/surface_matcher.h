// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/odometry/rgbd_tracking/options.h"
#include "rastro/odometry/rgbd_tracking/point_map.h"
#include "rastro/odometry/rgbd_tracking/pose_solver.h"
#include "rastro/registration/projective_icp.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// How well a frame's surfaces fit those of references.
struct SurfaceMatch {
  int compared = 0;  ///< Blocks of depth that fell on a surface.
  int fitting = 0;   ///< Of these, within the noise.
};

/// Fits the surfaces of frames to those of a map's references.
class SurfaceMatcher {
 public:
  explicit SurfaceMatcher(const RgbdOptions& options) : options_(options) {}

  /// The next frame; its surfaces are only looked at when asked for. `camera`: with its size.
  void take(const Frame& frame, const Camera& camera);
  bool has_surfaces() const { return !blocks_.empty(); }
  /// From now on the frame is compared with these references of the map: the one it shares most with, and the oldest
  /// that it shares enough with, which keeps drift small.
  void choose(const PointMap& map, const SE3& pose, const SE3& camera_from_depth);
  /// Against the chosen references, as the depth was taken at `camera_from_depth` from the colour picture. Weighed by
  /// the option, as blocks next to each other err together.
  PoseQuadratic compare(const PointMap& map, const SE3& pose, const SE3& camera_from_depth, double reach_m, int step,
                        SurfaceMatch* match = nullptr) const;
  /// The same with the delay of depth as an unknown; `velocity`: of the camera, per second.
  DelayedQuadratic compare_with_delay(const PointMap& map, const SE3& pose, const SE3& camera_from_depth,
                                      const Vector6d& velocity, double reach_m, int step) const;
  /// The frame's surfaces as those of a reference.
  void keep(Reference& reference, const SE3& camera_from_depth, const Vector6d& velocity) const;

 private:
  SurfaceFit fit_to(const Reference& reference, const SE3& pose, const SE3& camera_from_depth, double reach_m,
                    int step) const;

  const RgbdOptions& options_;
  std::optional<ProjectiveIcp> icp_;
  SurfaceOptions surface_options_;
  DepthBlocks blocks_;
  std::vector<int> chosen_;  ///< Numbers of references.
};

}  // namespace rastro
