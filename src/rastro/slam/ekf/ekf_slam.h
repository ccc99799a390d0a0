// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "rastro/slam/ekf/association.h"
#include "rastro/slam/ekf/body_motion.h"
#include "rastro/slam/ekf/consistency_check.h"
#include "rastro/slam/ekf/filter.h"
#include "rastro/slam/ekf/joint_compatibility.h"
#include "rastro/slam/ekf/keyframe_map.h"
#include "rastro/slam/ekf/landmark_room.h"
#include "rastro/slam/ekf/options.h"
#include "rastro/slam/ekf/stamp_check.h"
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
  Trajectory trajectory() const override { return keyframes_.trajectory(); }
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;
  bool set_mapping(bool on) override;
  std::vector<FeatureObservation> observations() const override { return observations_; }
  MapMemory map_memory() const override;

  const EkfFilter& filter() const { return filter_; }

 private:
  bool is_in_time(const Frame& frame, SlamUpdate& update);
  void predict(const Frame& frame, SlamUpdate& update);
  std::vector<LandmarkAssociation> recognize(std::span<const BodyObservation> observations, SlamUpdate& update);
  std::vector<BodyObservation> see(const Frame& frame, SlamUpdate& update) const;
  void correct(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations,
               SlamUpdate& update);
  void judge(std::span<const LandmarkAssociation> associations, SlamUpdate& update);
  void learn(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations,
             SlamUpdate& update);
  void check_consistency(SlamUpdate& update);
  void observe(std::span<const BodyObservation> observations, std::span<const LandmarkAssociation> associations);
  void recognize_place(SlamUpdate& update);
  void unite(const LandmarkPair& pair);
  void remove_landmark(std::size_t landmark);
  void confirm(std::size_t landmark, SlamUpdate& update);
  bool may_confirm() const;
  bool is_full() const;
  void forget_candidates();
  void keep(const Frame& frame, std::span<const LandmarkAssociation> associations, SlamUpdate& update);
  void stay_within_budget(SlamUpdate& update);
  std::size_t map_bytes() const;
  void say_pose(SlamUpdate& update) const;
  std::int64_t frame_number() const { return static_cast<std::int64_t>(keyframes_.frames()); }

  EkfOptions options_;
  bool scans_expected_;
  SE2 initial_pose_;
  MapBudget budget_;
  LandmarkRoom room_;
  bool maps_ = true;
  EkfFilter filter_;
  std::vector<LandmarkRecord> records_;  ///< Of the filter's landmarks.
  std::int64_t confirmed_ = 0;           ///< Candidates that became landmarks.
  bool place_grew_ = false;              ///< A landmark was observed often enough in this frame.

  StampCheck stamps_;
  BodyMotion motion_;
  ConsistencyCheck consistency_;
  double blind_m_ = 0.0;  ///< Path length since a landmark was last recognized.
  KeyframeMap keyframes_;
  std::vector<FeatureObservation> observations_;
};

}  // namespace rastro
