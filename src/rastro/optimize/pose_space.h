// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "rastro/map/graph/constraint.h"
#include "rastro/map/graph/planar.h"
#include "rastro/math/se2.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"
#include "rastro/optimize/pose_graph.h"
#include "rastro/optimize/right_jacobian_inverse.h"

namespace rastro {

/// The residual of an edge, rest = relative^-1 * from^-1 * to as a vector, its derivative by a step of `to`, and the
/// step of `to` with the same effect as a step of `from`.
template <int dimension>
struct LinearizedEdge {
  using Matrix = Eigen::Matrix<double, dimension, dimension>;
  Eigen::Matrix<double, dimension, 1> residual;
  Matrix by_to, to_by_from;
};

/// The differences between graphs of SE2, SE3 and Sim3:
/// - the parameters of a pose in the solver: Values, values_of(), pose_of();
/// - updates of poses: step(), difference();
/// - the measurement of an edge: relative(), information();
/// - the residual of an edge: residual() of the rest, linearize(), which computes derivatives only where asked.
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
  static Values step(const Values& pose, const Eigen::Vector3d& by) { return pose + by; }
  static Eigen::Vector3d difference(const Values& from, const Values& to) {
    return {to.x() - from.x(), to.y() - from.y(), std::remainder(to.z() - from.z(), 2.0 * M_PI)};
  }

  static SE2 relative(const Constraint& edge) { return in_plane(edge.rigid()); }
  static Eigen::Matrix3d information(const Constraint& edge, const PoseGraphOptions&) {
    return in_plane(edge.information);
  }
  static Eigen::Vector3d residual(const SE2& rest) { return values_of(rest); }

  /// An edge with its relative pose as numbers, since graphs of laser scans spend much of their time here.
  class Edge {
   public:
    explicit Edge(const SE2& relative)
        : rotation_(relative.rotation().inverse().matrix()),
          translation_(relative.translation()),
          yaw_(relative.rotation().angle()) {}
    LinearizedEdge<3> linearize(const Values& from, const Values& to, bool derivatives) const {
      const double c = std::cos(from.z()), s = std::sin(from.z());
      Eigen::Matrix2d from_world;
      from_world << c, s, -s, c;
      const Eigen::Vector2d observed = from_world * (to - from).head<2>();
      LinearizedEdge<3> edge;
      edge.residual << rotation_ * (observed - translation_), std::remainder(to.z() - from.z() - yaw_, 2.0 * M_PI);
      if (!derivatives) return edge;
      edge.by_to.setIdentity();
      edge.by_to.topLeftCorner<2, 2>() = rotation_ * from_world;
      edge.to_by_from = -Eigen::Matrix3d::Identity();
      edge.to_by_from.topRightCorner<2, 1>() << to.y() - from.y(), from.x() - to.x();
      return edge;
    }

   private:
    Eigen::Matrix2d rotation_;  ///< Inverse of the relative one.
    Eigen::Vector2d translation_;
    double yaw_;
  };
};

/// A step is pose * exp(step), and a residual a logarithm.
template <typename Group>
struct GroupSpace {
  using Space = PoseSpace<Group>;
  using Tangent = typename Group::Tangent;
  static constexpr int dimension = Tangent::RowsAtCompileTime;

  template <typename Values>
  static Values step(const Values& pose, const Tangent& by) {
    return Space::values_of(Space::pose_of(pose) * Group::exp(by));
  }
  template <typename Values>
  static Tangent difference(const Values& from, const Values& to) {
    return (Space::pose_of(from).inverse() * Space::pose_of(to)).log();
  }
  static Tangent residual(const Group& rest) { return rest.log(); }

  class Edge {
   public:
    explicit Edge(const Group& relative) : to_from_from_(relative.inverse()) {}
    template <typename Values>
    LinearizedEdge<dimension> linearize(const Values& from, const Values& to, bool derivatives) const {
      const Group from_from_to = Space::pose_of(from).inverse() * Space::pose_of(to);
      LinearizedEdge<dimension> edge;
      edge.residual = (to_from_from_ * from_from_to).log();
      if (!derivatives) return edge;
      edge.by_to = right_jacobian_inverse<Group>(edge.residual);
      edge.to_by_from = -from_from_to.inverse().adjoint();
      return edge;
    }

   private:
    Group to_from_from_;
  };
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
  static Values step(const Values& pose, Vector7d by) {
    constexpr double most = 50.0;
    by[6] = std::clamp(by[6], -most, most);
    return GroupSpace::step(pose, by);
  }

  static Sim3 relative(const Constraint& edge) { return edge.from_from_to; }
  static Matrix7d information(const Constraint& edge, const PoseGraphOptions& options) {
    Matrix7d information = Matrix7d::Zero();
    information.topLeftCorner<6, 6>() = edge.information;
    information(6, 6) = 1.0 / (1.0 / options.scale_information + edge.scale_variance);
    return information;
  }
};

}  // namespace rastro
