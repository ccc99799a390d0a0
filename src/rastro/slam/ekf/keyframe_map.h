// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "rastro/map/graph/map.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/trajectory.h"
#include "rastro/slam/ekf/grid_scans.h"
#include "rastro/slam/ekf/options.h"

namespace rastro {

/// What EKF-SLAM keeps of the frames: their poses, keyframes, and scans for the grid.
class KeyframeMap {
 public:
  /// `grid`: scans are kept.
  KeyframeMap(const EkfOptions& options, bool grid) : options_(options), grid_(grid) {}

  /// `maps`: it may become a keyframe (the first one does), and its scan may be kept. `scans_every`: see GridScans.
  void add(const Frame& frame, const SE2& world_from_body, bool maps, std::size_t scans_every);
  /// The first frame, the only one so far, was at this time: its stamp was wrong.
  void begin_at(TimeNs stamp) { trajectory_.front().stamp = keyframes_.front().stamp = stamp; }
  /// See GridScans.
  bool thin_scans() { return scans_.thin(); }

  std::size_t frames() const { return trajectory_.size(); }
  const Trajectory& trajectory() const { return trajectory_; }
  std::size_t bytes() const;
  /// Puts keyframes, constraints, frames and session into the map, and the scans if it has any.
  void put_into(Map& map) const;

 private:
  bool is_new_keyframe(const SE3& world_from_body) const;
  void put_constraints_into(Map& map) const;
  void put_scans_into(Map& map) const;

  EkfOptions options_;
  bool grid_;
  Trajectory trajectory_;
  std::vector<KeyframeId> keyframe_of_frame_;  ///< One per frame of the trajectory.
  std::vector<Keyframe> keyframes_;
  GridScans scans_;  ///< Of a keyframe: those up to the next one, in its body frame.
};

}  // namespace rastro
