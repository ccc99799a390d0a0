// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>

#include "rastro/backend/map_uncertainty.h"
#include "rastro/math/se2.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap_graph.h"

namespace rastro {

/// How uncertain poses of scans are in the world: by the match, by the cells, by the submap matched against, and by how
/// far wheels may have slipped along a direction that no scan shows. Covariances of (x, y, angle) are in local axes.
class PoseUncertainty {
 public:
  /// Both must outlive this.
  PoseUncertainty(const HectorOptions& options, const SubmapGraph& graph) : options_(options), graph_(graph) {}

  /// The robot moved by `path_m` to a scan with that unobservable direction, a unit vector in local axes. `measured`:
  /// by odometry; else it may have been faster or slower than before.
  void move(double path_m, bool measured, const std::optional<Eigen::Vector2d>& unseen_direction);
  /// All directions are observable again: what may have slipped until then stays in the submaps mapped meanwhile.
  void keep_slip();
  /// What may have slipped since all directions were last observable: for each scan the same error, growing with the
  /// path. Zero if they are now.
  Eigen::Matrix3d slip_covariance() const;

  /// In the world, of a scan's pose, from the covariance of its match with the oldest unfinished submap.
  Matrix6d of_pose(const SE2& local_from_body, const Eigen::Matrix3d& in_submap) const;
  /// `submap` begins at a pose of that covariance in the world.
  void begin_submap(std::size_t submap, const Matrix6d& covariance);
  /// All that is in the unfinished submaps has this error, too.
  void keep_in_submaps(const Eigen::Matrix3d& in_local);
  /// The unfinished submaps may be more certain by the loops of the graph from `first_loop` on; those of key scans
  /// before `first_key_scan` say nothing about them.
  void take_over_loops(std::size_t first_loop, std::size_t first_key_scan);

 private:
  void add_to_submap(std::size_t submap, const Eigen::Matrix3d& in_local);
  Eigen::Matrix3d slip_since(std::size_t submap) const;

  const HectorOptions& options_;
  const SubmapGraph& graph_;
  MapUncertainty submaps_;
  double unseen_path_m_ = 0.0;                      ///< Path length since all directions were last observable.
  double slip_m_ = 0.0;                             ///< Standard deviation gathered on it.
  Eigen::Vector2d slip_ = Eigen::Vector2d::Zero();  ///< The same along the direction.
  std::map<std::size_t, double> begun_at_m_;        ///< That path length where submaps began on it.
};

}  // namespace rastro
