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
#include "rastro/odometry/features/window_refinement.h"

namespace rastro {

/// A feature in a frame: its id and its undistorted normalised ray.
struct RaySighting {
  std::int64_t id = 0;
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();
};

/// RaySightings of one frame, in ascending order of id.
using RaySightings = std::vector<RaySighting>;

/// The ray of a feature in a frame.
const Eigen::Vector2d* find_ray(const RaySightings& sightings, std::int64_t id);

/// The last keyframes and the points in space seen from them.
class LocalMap {
 public:
  struct Keyframe {
    TimeNs stamp = 0;
    SE3 camera_from_world;
    RaySightings sightings;  ///< Kept while in the window.
  };

  /// `options` must outlive it; `focal_px` turns rays into pixels.
  LocalMap(const FeaturesOptions& options, double focal_px) : options_(options), focal_px_(focal_px) {}

  /// Forgets all points and the window's sightings; the poses of the keyframes stay.
  void restart();
  std::size_t add_keyframe(TimeNs stamp, const SE3& camera_from_world, RaySightings sightings);
  /// All keyframes ever, oldest first.
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::map<std::int64_t, Eigen::Vector3d>& points() const { return points_; }

  /// Places in space what the window sees from two sides well enough and has no point yet.
  int triangulate();
  /// Whether the window holds as many keyframes as it may.
  bool window_is_full() const;
  /// The window's keyframes and its points seen by two of them or more; the two oldest keyframes are fixed. `ids` gets
  /// one id a point.
  RefinementWindow window(std::vector<std::int64_t>& ids) const;
  /// Adjusts the window; the two oldest keyframes of it stay where they are. Returns the error in pixels.
  double refine();
  /// Drops points that any keyframe of the window sees too far off.
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
