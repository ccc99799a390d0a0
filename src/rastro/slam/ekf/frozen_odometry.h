// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "rastro/base/time.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/frame.h"
#include "rastro/slam/ekf/association.h"

namespace rastro {

/// Notices odometry that stays the same to the last bit while the body moves: its messages are missing. A robot that
/// stands still has the same odometry, but sees its landmarks where they were, and nearly the same scan.
class FrozenOdometry {
 public:
  /// Each frame, before its landmarks are associated.
  void add(const Frame& frame);
  /// The first frame, which was added, was at this time.
  void begin_at(TimeNs stamp) { since_ = stood_ = told_ = now_ = stamp; }
  /// Associations of this frame, made as if the body had not moved.
  void judge(std::span<const LandmarkAssociation> associations);
  /// The associations with which this frame corrects the filter.
  void end_frame(std::span<const LandmarkAssociation> associations);
  /// The body moves, and odometry does not tell.
  bool frozen() const { return frozen_; }
  /// Frozen, and without a landmark for so long that the next one could be mistaken for another.
  bool lost() const { return frozen_ && blind_ > most_blind; }
  /// The last frame had a landmark.
  bool recognized() const { return blind_ == 0; }
  /// Time up to this frame in which neither odometry nor a landmark told the motion.
  double unknown_seconds() const { return to_seconds(now_ - told_); }

  /// Odometry that changes again after it stayed the same, if no landmark told the motion lately. Its first step is of
  /// the whole time.
  struct Thaw {
    double seconds = 0.0;  ///< Over which it stayed the same.
    double share = 1.0;    ///< Of its part in which the body moved: without a landmark.
    bool frozen = false;   ///< The body was seen to move meanwhile.
  };
  /// With this frame.
  const std::optional<Thaw>& thaw() const { return thaw_; }

 private:
  static constexpr int most_blind = 5;

  void add_unmoved(const Frame& frame);
  void add_moved(const Frame& frame);
  /// Share of the beams that differ from that scan by more than `clear_m` and that share of their range; nullopt where
  /// none can be compared.
  std::optional<double> changed_share(const LaserScan& scan, double clear_m, double clear_range_share) const;

  std::optional<SE2> last_;
  std::optional<LaserScan> scan_;  ///< The first while odometry stayed the same.
  TimeNs since_ = 0;               ///< When odometry had its value first.
  TimeNs stood_ = 0;               ///< The last time that the scan was exactly as then.
  TimeNs told_ = 0;                ///< When odometry or a landmark told the motion last.
  TimeNs now_ = 0, recognized_ = 0;
  int unmoved_ = 0;  ///< Frames in which it was the same.
  int blind_ = 0;    ///< Frames in a row without a recognized landmark.
  std::optional<Thaw> thaw_;
  bool scan_still_ = false;  ///< Shows the same as that one.
  bool fitted_ = false;      ///< Landmarks were where the map has them when odometry stopped.
  bool frozen_ = false;
};

}  // namespace rastro
