// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <optional>
#include <span>

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
  /// Associations of this frame, made as if the body had not moved.
  void judge(std::span<const LandmarkAssociation> associations);
  /// The associations with which this frame corrects the filter.
  void end_frame(std::span<const LandmarkAssociation> associations);
  /// The body moves, and odometry does not tell.
  bool frozen() const { return frozen_; }
  /// Frozen, and without a landmark for so long that the next one could be mistaken for another.
  bool lost() const { return frozen_ && blind_ > most_blind; }
  /// Frames up to this one, one at least, over which neither odometry nor a landmark told the motion.
  int unknown_frames() const { return std::max(1, std::min(unmoved_, blind_ + 1)); }

  /// Odometry that changes again after it stayed the same, if no landmark told the motion lately. Its first step is of
  /// the whole time.
  struct Thaw {
    double seconds = 0.0;  ///< Over which it stayed the same.
    double share = 1.0;    ///< Of them, without a landmark.
    bool frozen = false;   ///< The body was seen to move meanwhile.
  };
  /// With this frame.
  const std::optional<Thaw>& thaw() const { return thaw_; }

 private:
  static constexpr int most_blind = 5;

  void add_unmoved(const Frame& frame);
  void add_moved(const Frame& frame);
  double changed_share(const LaserScan& scan) const;

  std::optional<SE2> last_;
  std::optional<LaserScan> scan_;  ///< The first while odometry stayed the same.
  TimeNs since_ = 0;               ///< When odometry had its value first.
  TimeNs now_ = 0, recognized_ = 0;
  int unmoved_ = 0;  ///< Frames in which it was the same.
  int blind_ = 0;    ///< Frames in a row without a recognized landmark.
  std::optional<Thaw> thaw_;
  bool scan_still_ = false;  ///< Shows the same as that one.
  bool fitted_ = false;      ///< Landmarks were where the map has them when odometry stopped.
  bool frozen_ = false;
};

}  // namespace rastro
