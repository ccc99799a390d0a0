// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/planar.h"

#include <cmath>

namespace rastro {
namespace {

constexpr int planar[] = {0, 1, 5};  ///< Indices of x, y and the rotation about z in a pose in space.

}  // namespace

SE3 in_space(const SE2& pose) {
  const Eigen::Vector3d rotation(0.0, 0.0, pose.rotation().angle());
  return SE3(SO3::exp(rotation), Eigen::Vector3d(pose.translation().x(), pose.translation().y(), 0.0));
}

SE2 in_plane(const SE3& pose) {
  const Eigen::Vector3d ahead = pose.rotation() * Eigen::Vector3d::UnitX();
  return {SO2::from_angle(std::atan2(ahead.y(), ahead.x())), pose.translation().head<2>()};
}

Matrix6d in_space(const Eigen::Matrix3d& covariance) {
  Matrix6d full = Matrix6d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) full(planar[i], planar[j]) = covariance(i, j);
  return full;
}

Eigen::Matrix3d in_plane(const Matrix6d& covariance) {
  Eigen::Matrix3d part;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) part(i, j) = covariance(planar[i], planar[j]);
  return part;
}

Constraint planar_constraint(KeyframeId from, KeyframeId to, const SE2& from_from_to,
                             const Eigen::Matrix3d& information, ConstraintKind kind) {
  constexpr double never_leaves_the_plane = 1e6;
  Constraint constraint;
  constraint.from = from;
  constraint.to = to;
  constraint.from_from_to = Sim3(in_space(from_from_to));
  // Errors on the right of the relative pose are in the axes of `to`.
  Eigen::Matrix3d to_from_to_axes = Eigen::Matrix3d::Identity();
  to_from_to_axes.topLeftCorner<2, 2>() = from_from_to.rotation().inverse().matrix();
  constraint.information = in_space(Eigen::Matrix3d(to_from_to_axes * information * to_from_to_axes.transpose()));
  for (const int unmoved : {2, 3, 4}) constraint.information(unmoved, unmoved) = never_leaves_the_plane;
  constraint.kind = kind;
  return constraint;
}

}  // namespace rastro
