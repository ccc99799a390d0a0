// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rastro/multiview/point_pairs.h"
#include "rastro/odometry/classic/options.h"
#include "rastro/odometry/odometry.h"
#include "rastro/odometry/ray_observations.h"

namespace rastro {

/// The motion of a camera from the matches of its last three frames, METHODS 2.1. Frames k-2 and k-1 give an essential
/// matrix, of whose four motions the one with most points in front of both cameras counts, and their points; P3P on
/// those found in k gives its pose. So k has the unit of length of k-2 and k-1, which carries the unit of the first
/// pair, 1, along. A frame that hardly moved beyond a rotation does not become k-1: METHODS 2.6.
class ThreeViewChain {
 public:
  /// `options` must outlive it; `focal_px` converts rays to pixels.
  ThreeViewChain(const ClassicOptions& options, double focal_px) : options_(options), focal_px_(focal_px) {}

  /// A frame with its observations. Takes the stamp of `update`; sets its state, reason, pose and counts.
  void add(RayObservations observations, OdometryUpdate& update);
  /// A frame without information, whose reason is known: the last motion is repeated.
  void bridge(OdometryUpdate& update);

  /// world_from_camera of every frame; world: the first camera.
  const Trajectory& trajectory() const { return trajectory_; }
  /// Of the points sought in the last frame: id, and whether it is an inlier of the pose. Ascending ids.
  const std::vector<std::pair<std::int64_t, bool>>& located() const { return located_; }

 private:
  struct View {
    RayObservations observations;
    std::size_t position = 0;  ///< In trajectory_.
    SE3 world_from_camera;
  };
  struct KnownPoint {
    std::int64_t id = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< In the camera frame of k-2; k-1 is at distance 1.
  };
  /// Motion between two views, its translation of length 1.
  struct PairMotion {
    SE3 second_from_first;
    bool has_parallax = false;
    int inliers = 0;  ///< In front of both cameras.
  };

  void start(View current, OdometryUpdate& update);
  void rest(OdometryUpdate& update);
  void locate(View current, OdometryUpdate& update);
  std::optional<PairMotion> motion_of_pair(const SharedRays& shared, std::size_t position) const;
  std::optional<SE3> motion_from_points(const View& current, OdometryUpdate& update);
  void accept(const SE3& second_from_current, View& current);
  void move_on(View current, const PairMotion& pair);
  void follow_rotation(const SharedRays& shared, const PairMotion& pair, OdometryUpdate& update);
  void follow_direction(View current, const PairMotion& pair, OdometryUpdate& update);
  void lose(View current, OdometryReason reason, std::string detail, OdometryUpdate& update);
  void repeat_motion();
  CalibratedRansacOptions ransac(double max_error_px, std::uint64_t item) const;

  const ClassicOptions& options_;
  double focal_px_;
  std::optional<View> second_;      ///< k-1; the points hold what k-2 gives.
  std::vector<KnownPoint> points_;  ///< From k-2 and k-1, ascending ids; empty: not triangulated.
  SE3 second_from_first_;           ///< k-1 from k-2, in the unit of the points.
  double length_ = 1.0;             ///< Of that motion in the unit of the trajectory.
  double speed_ = 0.0;              ///< Length of the last motion that was not zero, a frame; 0: none yet.
  SE3 step_;                        ///< last camera from the one a frame later, at the last motion.
  int repeated_ = 0;                ///< Frames in a row without an estimate.
  std::vector<std::pair<std::int64_t, bool>> located_;
  Trajectory trajectory_;
  SE3 world_from_last_;
};

}  // namespace rastro
