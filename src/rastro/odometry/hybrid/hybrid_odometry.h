// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/odometry/hybrid/options.h"
#include "rastro/odometry/hybrid/two_point.h"
#include "rastro/odometry/odometry.h"
#include "rastro/registration/profiles/rotation_chain.h"
#include "rastro/track/tracker.h"

namespace rastro {

/// The hybrid odometry of METHODS 2.3. The profiles give the camera's rotation; its translation comes from points that
/// are triangulated from frames k-2 and k-1 and observed in k. k-1 and k-2 are the last two frames with enough motion
/// between them, METHODS 2.6. The first motion has length 1, and the points propagate that scale. Where they cannot,
/// the last motion is repeated and its speed gives the scale of the re-initialization.
class HybridOdometry : public Odometry {
 public:
  /// Throws Error for settings out of range. The pool must outlive the odometry; without one all runs in the caller's
  /// thread.
  HybridOdometry(const HybridOptions& options, const Camera& camera, TaskPool* pool = nullptr);

  OdometryUpdate process(const Frame& frame) override;
  Trajectory trajectory() const override { return trajectory_; }
  std::vector<OdometryFeature> features() const override;

 private:
  struct View {
    SE3 world_from_camera;
    std::vector<TrackedFeature> features;  ///< In ascending order of id.
    std::size_t position = 0;              ///< In trajectory_.
  };
  struct KnownPoint {
    std::int64_t id = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< In the camera frame of `first_`.
  };
  /// Pixels of the same points in two views.
  struct Shared {
    std::vector<Eigen::Vector2d> a, b;  ///< Normalized.
    std::vector<std::int64_t> ids;
    double motion_px = 0.0;    ///< Median.
    double parallax_px = 0.0;  ///< Median after removing the rotation.
  };

  void follow(const Frame& frame, OdometryUpdate& update);
  void start(View current, OdometryUpdate& update);
  void locate(View current, OdometryUpdate& update);
  void accept(View current, const Shared& since_second);
  void lose(View current, OdometryReason reason, std::string detail, OdometryUpdate& update);
  void bridge(OdometryUpdate& update);
  void interpolate_between(std::size_t first, std::size_t last);
  Shared shared_between(const View& a, const View& b) const;
  std::vector<KnownPoint> triangulate_between(const View& a, const View& b) const;
  CalibratedRansacOptions ransac_options(std::uint64_t item) const;
  SE3 predicted(const SO3& world_from_current) const;
  double frames_since_used(const View& current) const { return static_cast<double>(current.position - used_.position); }

  HybridOptions options_;
  Camera camera_;
  FrameCheck check_;
  RotationChain rotations_;
  Tracker tracker_;
  SO3 world_from_rotated_;            ///< Last rotation measured, from the profiles alone.
  std::vector<TrackedFeature> seen_;  ///< In the last frame.
  std::optional<View> first_, second_;
  std::vector<KnownPoint> points_;
  /// Of the last frame that was not bridged.
  struct Used {
    SE3 world_from_camera;
    std::size_t position = 0;  ///< In trajectory_.
  };
  Used used_;
  Trajectory trajectory_;
  SE3 world_from_last_;                                 ///< Also of a bridged frame.
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  ///< A frame's motion in its own camera frame.
  double speed_ = 0.0;                                  ///< Length of the last motion that was not zero; 0: none yet.
  int bridged_ = 0;                                     ///< Rejected frames since the last usable one.
};

}  // namespace rastro
