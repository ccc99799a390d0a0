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
#include "rastro/slam/ekf/motion_model.h"
#include "rastro/slam/ekf/odometry_check.h"
#include "rastro/slam/ekf/options.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// EKF-SLAM in the plane, METHODS 3: Durrant-Whyte and Bailey 2006; Thrun, Burgard and Fox 2005, chapter 10. The world
/// is where the first frame's body stood. A filter: what it once said of a pose it does not take back.
class EkfSlam : public Slam {
 public:
  /// `scans_expected`: a frame without a scan lacks something.
  EkfSlam(const EkfOptions& options, bool scans_expected);

  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override;
  Trajectory trajectory() const override { return trajectory_; }
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;
  bool set_mapping(bool on) override;

  const EkfFilter& filter() const { return filter_; }

 private:
  void predict(const Frame& frame, SlamUpdate& update);
  Motion motion_since_last(const Frame& frame, SlamUpdate& update);
  Motion motion_by_odometry(const SE2& odometry_from_body, double seconds, SlamUpdate& update);
  std::vector<BodySighting> see(const Frame& frame, SlamUpdate& update) const;
  void correct(std::span<const BodySighting> sightings, std::span<const LandmarkAssociation> associations,
               SlamUpdate& update);
  void judge(std::span<const LandmarkAssociation> associations, SlamUpdate& update);
  void learn(std::span<const BodySighting> sightings, std::span<const LandmarkAssociation> associations,
             SlamUpdate& update);
  void confirm(std::size_t landmark, SlamUpdate& update);
  void forget_candidates();
  void keep(const Frame& frame, SlamUpdate& update);
  void add_keyframe(const Frame& frame, const SE3& world_from_body);
  void say_pose(SlamUpdate& update) const;
  std::shared_ptr<const LandmarkLayer> landmarks() const;

  EkfOptions options_;
  bool scans_expected_;
  bool maps_ = true;
  EkfFilter filter_;
  std::vector<LandmarkRecord> records_;  ///< Of the filter's landmarks.
  std::int64_t confirmed_ = 0;           ///< Candidates that became landmarks.
  OdometryCheck odometry_check_;

  std::optional<TimeNs> last_stamp_;
  std::optional<SE2> last_odometry_;  ///< Of the frame before this one; nothing where that had none.
  SE2 last_motion_;                   ///< The last that odometry told, over last_seconds_.
  double last_seconds_ = 0.0;
  double blind_m_ = 0.0;  ///< Way since a landmark was last recognised.

  Trajectory trajectory_;
  std::vector<KeyframeId> keyframe_of_frame_;  ///< One a frame of the trajectory.
  std::vector<Keyframe> keyframes_;
  std::vector<KeyframeScans> scans_;  ///< One a keyframe: of the frames up to the next, in its body frame.
};

}  // namespace rastro
