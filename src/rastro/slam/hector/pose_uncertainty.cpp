// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/pose_uncertainty.h"

#include "rastro/map/graph/planar.h"

namespace rastro {
namespace {

/// Covariance of (x, y, angle) in axes rotated by `rotation`.
Eigen::Matrix3d in_rotated_axes(const Eigen::Matrix3d& covariance, const SO2& rotation) {
  Eigen::Matrix3d by = Eigen::Matrix3d::Identity();
  by.topLeftCorner<2, 2>() = rotation.matrix();
  return by * covariance * by.transpose();
}

}  // namespace

void PoseUncertainty::move(double path_m, const std::optional<OdometryError>& error,
                           const std::optional<Eigen::Vector2d>& unseen_direction) {
  if (!unseen_direction) {
    keep_slip();
    return;
  }
  constexpr OdometryError of_assumed_speed{.share = 0.25};
  const OdometryError slip = error.value_or(of_assumed_speed);
  lasting_m_ += slip.share * path_m;
  random_m2_ += slip.variance_per_m * path_m;
  of_any_robot_m_ += (error ? options_.odometry_sigma_share : slip.share) * path_m;
  direction_ = *unseen_direction;
}

void PoseUncertainty::keep_slip() {
  if (slip_m2() > 0.0) {
    for (std::size_t s = 0; s < graph_.submaps().size(); ++s)
      if (!graph_.submaps()[s]->finished()) add_to_submap(s, slip_since(s));
  }
  lasting_m_ = random_m2_ = of_any_robot_m_ = 0.0;
  begun_with_m2_.clear();
}

Eigen::Matrix3d PoseUncertainty::slip_of_constraints() const { return along_path(of_any_robot_m_ * of_any_robot_m_); }

Eigen::Matrix3d PoseUncertainty::along_path(double variance_m2) const {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance.topLeftCorner<2, 2>() = variance_m2 * direction_ * direction_.transpose();
  return covariance;
}

/// What a submap that began on the path has of it already counts once: it is one error that grows, not several.
Eigen::Matrix3d PoseUncertainty::slip_since(std::size_t submap) const {
  const auto begun = begun_with_m2_.find(submap);
  return along_path(slip_m2() - (begun == begun_with_m2_.end() ? 0.0 : begun->second));
}

/// Cells hold the walls to a part of their size, the same for all beams of a scan and all scans of a submap.
Eigen::Matrix3d PoseUncertainty::of_cells() const {
  constexpr double share_of_cell = 0.6, sigma_rad = 0.002;
  const double sigma_m = share_of_cell * options_.cell_m;
  return Eigen::Vector3d(sigma_m, sigma_m, sigma_rad).cwiseAbs2().asDiagonal();
}

Matrix6d PoseUncertainty::of_pose(const SE2& local_from_body, const Eigen::Matrix3d& in_submap) const {
  return in_world(local_from_body, in_submap + of_cells());
}

Matrix6d PoseUncertainty::of_submap(const SE2& local_from_body, const Eigen::Matrix3d& in_last) const {
  constexpr double share_of_mean = 0.25;
  return in_world(local_from_body, in_last + share_of_mean * of_cells());
}

Matrix6d PoseUncertainty::in_world(const SE2& local_from_body, const Eigen::Matrix3d& in_submap) const {
  std::size_t open = 0;
  while (open + 1 < graph_.submaps().size() && graph_.submaps()[open]->finished()) ++open;
  const SE2 world_from_local = graph_.world_from_local();
  return submaps_.of_pose(static_cast<std::int64_t>(open), in_space(world_from_local * local_from_body).translation(),
                          in_space(in_rotated_axes(in_submap + slip_since(open), world_from_local.rotation())));
}

void PoseUncertainty::begin_submap(std::size_t submap, const Matrix6d& covariance) {
  submaps_.set(static_cast<std::int64_t>(submap), in_space(graph_.world_from_submap(submap)).translation(), covariance);
  if (slip_m2() > 0.0) begun_with_m2_[submap] = slip_m2();
}

void PoseUncertainty::keep_in_submaps(const Eigen::Matrix3d& in_local) {
  for (std::size_t s = 0; s < graph_.submaps().size(); ++s)
    if (!graph_.submaps()[s]->finished()) add_to_submap(s, in_local);
}

void PoseUncertainty::add_to_submap(std::size_t submap, const Eigen::Matrix3d& in_local) {
  const Matrix6d in_world = in_space(in_rotated_axes(in_local, graph_.world_from_local().rotation()));
  const Eigen::Vector3d position = in_space(graph_.world_from_submap(submap)).translation();
  const auto part = static_cast<std::int64_t>(submap);
  submaps_.set(part, position, submaps_.of_pose(part, position, in_world));
}

void PoseUncertainty::take_over_loops(std::size_t first_loop, std::size_t first_key_scan) {
  for (std::size_t l = first_loop; l < graph_.loops().size(); ++l) {
    const ClosedLoop& loop = graph_.loops()[l];
    if (loop.key_scan < first_key_scan) continue;
    const SE2 pose = graph_.world_from_key_scan(loop.key_scan);
    const Eigen::Vector3d position = in_space(pose).translation();
    const SO2 world_from_submap = graph_.world_from_submap(loop.submap).rotation();
    const Matrix6d covariance =
        submaps_.of_pose(static_cast<std::int64_t>(loop.submap), position,
                         in_space(in_rotated_axes(loop.covariance + of_cells(), world_from_submap)));
    for (std::size_t s = 0; s < graph_.submaps().size(); ++s)
      if (!graph_.submaps()[s]->finished()) submaps_.reduce(static_cast<std::int64_t>(s), position, covariance);
  }
}

}  // namespace rastro
