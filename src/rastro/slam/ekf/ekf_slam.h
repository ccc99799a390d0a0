// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/slam/ekf/association.h"
#include "rastro/slam/ekf/filter.h"
#include "rastro/slam/ekf/frozen_odometry.h"
#include "rastro/slam/ekf/motion_model.h"
#include "rastro/slam/ekf/odometry_check.h"
#include "rastro/slam/ekf/options.h"
#include "rastro/slam/map_budget.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// EKF-SLAM in the plane, METHODS 3: Durrant-Whyte and Bailey 2006; Thrun, Burgard and Fox 2005, chapter 10. The world
/// is the body frame of the first frame, unless an initial pose is given. This is a filter: it never revises a pose
/// that it has reported.
class EkfSlam : public Slam {
 public:
  /// `scans_expected`: report frames without a scan. `initial_pose`: world_from_body at the first frame.
  /// `map_budget_bytes`: memory limit of the map, see MapBudget; 0: unlimited.
  EkfSlam(const EkfOptions& options, bool scans_expected, const SE2& initial_pose = {},
          std::size_t map_budget_bytes = 0);

  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override;
  Trajectory trajectory() const override { return trajectory_; }
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;
  bool set_mapping(bool on) override;
  std::vector<FeatureObservation> observations() const override { return observations_; }
  MapMemory map_memory() const override;

  const EkfFilter& filter() const { return filter_; }

 private:
  struct LastFrame {
    std::optional<TimeNs> stamp;  ///< Nothing before the first frame.
    std::optional<SE2> odometry;  ///< Nothing where the frame had none.
    SE2 motion;                   ///< The last that odometry told, over `seconds`.
    double seconds = 0.0;
  };

  void predict(const Frame& frame, SlamUpdate& update);
  Motion motion_since_last(const Frame& frame, SlamUpdate& update);
  Motion motion_by_odometry(const SE2& odometry_from_body, double seconds, SlamUpdate& update);
  Motion unknown_motion(double frame_seconds) const;
  Motion motion_after_frozen(const SE2& last_from_body, SlamUpdate& update);
  std::vector<LandmarkAssociation> recognize(const Frame& frame, std::span<const BodyObservation> observations,
                                             SlamUpdate& update);
  std::vector<BodyObservation> see(const Frame& frame, SlamUpdate& update) const;
  void correct(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations,
               SlamUpdate& update);
  void judge(std::span<const LandmarkAssociation> associations, SlamUpdate& update);
  void learn(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations,
             SlamUpdate& update);
  void observe(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations);
  void recognize_place(SlamUpdate& update);
  void remove_landmark(std::size_t landmark);
  bool has_room() const;
  void confirm(std::size_t landmark, SlamUpdate& update);
  void forget_candidates();
  void keep(const Frame& frame, SlamUpdate& update);
  void add_keyframe(const Frame& frame, const SE3& world_from_body);
  void keep_scan(const LaserScan& scan, const SE2& world_from_body);
  void stay_within_budget(SlamUpdate& update);
  bool thin_scans();
  std::size_t landmark_bytes() const;
  std::size_t map_bytes() const;
  void say_pose(SlamUpdate& update) const;
  std::shared_ptr<const LandmarkLayer> landmarks() const;

  EkfOptions options_;
  bool scans_expected_;
  SE2 initial_pose_;
  MapBudget budget_;
  bool maps_ = true;
  EkfFilter filter_;
  std::vector<LandmarkRecord> records_;  ///< Of the filter's landmarks.
  std::int64_t confirmed_ = 0;           ///< Candidates that became landmarks.
  bool place_grew_ = false;              ///< A landmark was observed often enough in this frame.
  OdometryCheck odometry_check_;
  FrozenOdometry frozen_odometry_;

  LastFrame last_;
  double blind_m_ = 0.0;  ///< Path length since a landmark was last recognized.

  std::vector<FeatureObservation> observations_;
  Trajectory trajectory_;
  std::vector<KeyframeId> keyframe_of_frame_;  ///< One per frame of the trajectory.
  std::vector<Keyframe> keyframes_;
  std::vector<KeyframeScans> scans_;             ///< One per keyframe, up to the next one, in its body frame.
  std::size_t scans_seen_ = 0, scan_bytes_ = 0;  ///< Scans offered for the grid; memory of those kept.
};

}  // namespace rastro
