// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "rastro/map/graph/constraint.h"
#include "rastro/map/graph/planar.h"
#include "rastro/math/se2.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"
#include "rastro/optimize/pose_graph.h"
#include "rastro/optimize/right_jacobian_inverse.h"

namespace rastro {

/// The differences between graphs of SE2, SE3 and Sim3:
/// - the parameters of a pose in the solver: Values, values_of(), pose_of();
/// - updates of poses: step(), difference();
/// - the measurement of an edge: relative(), information();
/// - the residual of an edge, rest = relative^-1 * from^-1 * to, as a vector: residual(), its derivative by a step of
///   `to`, and the step of `to` with the same effect as a step of `from`.
template <GraphPose Pose>
struct PoseSpace;

/// A step is added to x, y and yaw, and a residual is x, y and yaw.
template <>
struct PoseSpace<SE2> {
  static constexpr int dimension = 3;
  using Values = Eigen::Vector3d;

  static Values values_of(const SE2& pose) {
    return {pose.translation().x(), pose.translation().y(), pose.rotation().angle()};
  }
  static SE2 pose_of(const Values& values) { return {SO2::from_angle(values.z()), values.head<2>()}; }
  static SE2 step(const SE2& pose, const Eigen::Vector3d& by) {
    return {pose.rotation() * SO2::from_angle(by.z()), pose.translation() + by.head<2>()};
  }
  static Eigen::Vector3d difference(const SE2& from, const SE2& to) {
    const Eigen::Vector2d offset = to.translation() - from.translation();
    return {offset.x(), offset.y(), (from.rotation().inverse() * to.rotation()).angle()};
  }

  static SE2 relative(const Constraint& edge) { return in_plane(edge.rigid()); }
  static Eigen::Matrix3d information(const Constraint& edge, const PoseGraphOptions&) {
    return in_plane(edge.information);
  }
  static Eigen::Vector3d residual(const SE2& rest) { return values_of(rest); }
  static Eigen::Matrix3d residual_by_to(const Eigen::Vector3d&, const SE2& rest, const SE2& to) {
    Eigen::Matrix3d by_to = Eigen::Matrix3d::Identity();
    by_to.topLeftCorner<2, 2>() = (rest.rotation() * to.rotation().inverse()).matrix();
    return by_to;
  }
  static Eigen::Matrix3d to_by_from(const SE2& from, const SE2& from_from_to) {
    const Eigen::Vector2d offset = from.rotation() * from_from_to.translation();
    Eigen::Matrix3d to_by_from = -Eigen::Matrix3d::Identity();
    to_by_from.topRightCorner<2, 1>() << offset.y(), -offset.x();
    return to_by_from;
  }
};

/// A step is pose * exp(step), and a residual a logarithm.
template <typename Group>
struct GroupSpace {
  using Tangent = typename Group::Tangent;
  static constexpr int dimension = Tangent::RowsAtCompileTime;
  using Matrix = Eigen::Matrix<double, dimension, dimension>;

  static Group step(const Group& pose, const Tangent& by) { return pose * Group::exp(by); }
  static Tangent difference(const Group& from, const Group& to) { return (from.inverse() * to).log(); }
  static Tangent residual(const Group& rest) { return rest.log(); }
  static Matrix residual_by_to(const Tangent& residual, const Group&, const Group&) {
    return right_jacobian_inverse<Group>(residual);
  }
  static Matrix to_by_from(const Group&, const Group& from_from_to) { return -from_from_to.inverse().adjoint(); }
};

/// x y z, then qx qy qz qw.
template <>
struct PoseSpace<SE3> : GroupSpace<SE3> {
  using Values = Eigen::Matrix<double, 7, 1>;

  static Values values_of(const SE3& pose) {
    return (Values() << pose.translation(), pose.rotation().quaternion().coeffs()).finished();
  }
  static SE3 pose_of(const Values& values) { return {SO3(Eigen::Quaterniond(values.tail<4>())), values.head<3>()}; }

  static SE3 relative(const Constraint& edge) { return edge.rigid(); }
  static Matrix6d information(const Constraint& edge, const PoseGraphOptions&) { return edge.information; }
};

/// x y z, qx qy qz qw, scale.
template <>
struct PoseSpace<Sim3> : GroupSpace<Sim3> {
  using Values = Eigen::Matrix<double, 8, 1>;

  static Values values_of(const Sim3& pose) {
    return (Values() << pose.translation(), pose.rotation().quaternion().coeffs(), pose.scale()).finished();
  }
  static Sim3 pose_of(const Values& values) {
    return {values[7], SO3(Eigen::Quaterniond(values.segment<4>(3))), values.head<3>()};
  }
  /// The solver also evaluates whole gradients as steps, whatever their unit: this bounds the change of a scale.
  static Sim3 step(const Sim3& pose, Vector7d by) {
    constexpr double most = 50.0;
    by[6] = std::clamp(by[6], -most, most);
    return GroupSpace::step(pose, by);
  }

  static Sim3 relative(const Constraint& edge) { return edge.from_from_to; }
  static Matrix7d information(const Constraint& edge, const PoseGraphOptions& options) {
    Matrix7d information = Matrix7d::Zero();
    information.topLeftCorner<6, 6>() = edge.information;
    information(6, 6) = options.scale_information;
    return information;
  }
};

}  // namespace rastro
