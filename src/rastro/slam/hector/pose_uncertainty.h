// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>

#include "rastro/backend/map_uncertainty.h"
#include "rastro/math/se2.h"
#include "rastro/slam/hector/odometry_scale.h"
#include "rastro/slam/hector/options.h"
#include "rastro/slam/hector/submap_graph.h"

namespace rastro {

/// How uncertain poses of scans are in the world: by the match, by the cells, by the submap matched against, and by how
/// far wheels may have slipped along a direction that no scan shows. Covariances of (x, y, angle) are in local axes.
class PoseUncertainty {
 public:
  /// Both must outlive this.
  PoseUncertainty(const HectorOptions& options, const SubmapGraph& graph) : options_(options), graph_(graph) {}

  /// The robot moved by `path_m` to a scan with that unobservable direction, a unit vector in local axes. `error`: of
  /// odometry that measured it; without, it may have been faster or slower than before.
  void move(double path_m, const std::optional<OdometryError>& error,
            const std::optional<Eigen::Vector2d>& unseen_direction);
  /// All directions are observable again: what may have slipped until then stays in the submaps mapped meanwhile.
  void keep_slip();
  /// For the graph, what wheels of any robot may have slipped since all directions were last observable, zero if they
  /// are now. It is one error, in the constraints of all these scans, and the graph takes each for another one: with
  /// what is learned of this robot they would hold against loop closures.
  Eigen::Matrix3d slip_of_constraints() const;

  /// In the world, of a scan's pose, from the covariance of its match with the oldest unfinished submap.
  Matrix6d of_pose(const SE2& local_from_body, const Eigen::Matrix3d& in_submap) const;
  /// The same of a submap that begins there: its scans are matched one by one, so that it is wrong by the mean of what
  /// cells add to each.
  Matrix6d of_submap(const SE2& local_from_body, const Eigen::Matrix3d& in_last) const;
  /// `submap` begins at a pose of that covariance in the world.
  void begin_submap(std::size_t submap, const Matrix6d& covariance);
  /// All that is in the unfinished submaps has this error, too.
  void keep_in_submaps(const Eigen::Matrix3d& in_local);
  /// The unfinished submaps may be more certain by the loops of the graph from `first_loop` on; those of key scans
  /// before `first_key_scan` say nothing about them.
  void take_over_loops(std::size_t first_loop, std::size_t first_key_scan);

 private:
  Eigen::Matrix3d along_path(double variance_m2) const;
  double slip_m2() const { return lasting_m_ * lasting_m_ + random_m2_; }
  Eigen::Matrix3d of_cells() const;
  Matrix6d in_world(const SE2& local_from_body, const Eigen::Matrix3d& in_submap) const;
  void add_to_submap(std::size_t submap, const Eigen::Matrix3d& in_local);
  Eigen::Matrix3d slip_since(std::size_t submap) const;

  const HectorOptions& options_;
  const SubmapGraph& graph_;
  MapUncertainty submaps_;
  /// Gathered since all directions were last observable: of errors that stay the same (standard deviation), and of
  /// those that do not (variance).
  double lasting_m_ = 0.0, random_m2_ = 0.0;
  double of_any_robot_m_ = 0.0;
  Eigen::Vector2d direction_ = Eigen::Vector2d::Zero();
  std::map<std::size_t, double> begun_with_m2_;  ///< Variance at which submaps began.
};

}  // namespace rastro
