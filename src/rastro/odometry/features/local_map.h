// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/math/se3.h"
#include "rastro/odometry/features/options.h"
#include "rastro/odometry/ray_observations.h"
#include "rastro/optimize/window_refinement.h"

namespace rastro {

/// The last keyframes and the map points observed in them.
class LocalMap {
 public:
  struct Keyframe {
    TimeNs stamp = 0;
    SE3 camera_from_world;
    RayObservations observations;  ///< Kept while the keyframe is in the window.
  };

  /// `options` must outlive it; `focal_px` converts rays to pixels.
  LocalMap(const FeaturesOptions& options, double focal_px) : options_(options), focal_px_(focal_px) {}

  /// Forgets all points and the window's observations. The poses of the keyframes stay.
  void restart();
  std::size_t add_keyframe(TimeNs stamp, const SE3& camera_from_world, RayObservations observations);
  /// All keyframes ever, oldest first.
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::map<std::int64_t, Eigen::Vector3d>& points() const { return points_; }

  /// Triangulates points that the window observes with enough parallax and that are not in the map yet.
  int triangulate();
  /// Whether the window has its full number of keyframes.
  bool window_is_full() const;
  /// The window's keyframes and its points with two or more observations; the two oldest keyframes are fixed. `ids`
  /// gets one id per point.
  RefinementWindow window(std::vector<std::int64_t>& ids) const;
  /// Bundle-adjusts the window with its two oldest keyframes fixed. Returns the RMS reprojection error in pixels.
  double refine();
  /// Drops points whose reprojection error is too large in any keyframe of the window.
  void drop_bad_points();

 private:
  std::size_t window_begin() const;

  const FeaturesOptions& options_;
  double focal_px_;
  std::size_t restarted_at_ = 0;
  std::vector<Keyframe> keyframes_;
  std::map<std::int64_t, Eigen::Vector3d> points_;
};

}  // namespace rastro
