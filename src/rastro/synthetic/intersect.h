// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "rastro/synthetic/scene.h"

namespace rastro {

/// Exact first intersection of a ray with a solid from outside. The oracle and the renderer share this one function, so
/// that both give the same bits. Origins are given in the solid's frame, because the camera's origin is the same for a
/// whole image.
struct Intersection {
  double t = std::numeric_limits<double>::infinity();  ///< Infinite if the ray misses the solid.
  int face = 0;
};

inline Eigen::Vector3d to_local(const Primitive& primitive, const Eigen::Vector3d& vector) {
  if (primitive.aligned) return vector;
  return primitive.world_from_local.transpose() * vector;
}

namespace detail {

/// Path length per step along each axis. A tiny slope in place of zero avoids infinity times zero.
inline Eigen::Vector3d inverse_of(const Eigen::Vector3d& direction) {
  return direction.unaryExpr([](double slope) { return 1.0 / (slope == 0.0 ? 1e-300 : slope); });
}

inline Intersection intersect_box(const Eigen::Vector3d& half, const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& inverses) {
  double enter = 0.0, leave = std::numeric_limits<double>::infinity();
  int face = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse = inverses[axis];
    const double side = inverse > 0.0 ? -half[axis] : half[axis];
    const double near = (side - origin[axis]) * inverse;
    const double far = (-side - origin[axis]) * inverse;
    if (near > enter) {
      enter = near;
      face = 2 * axis + (inverse > 0.0 ? 1 : 0);
    }
    if (far < leave) leave = far;
  }
  if (face < 0 || enter > leave) return {};
  return {enter, face};
}

inline Intersection intersect_quad(const Eigen::Vector3d& half, const Eigen::Vector3d& origin,
                                   const Eigen::Vector3d& direction) {
  const double t = -origin.z() / direction.z();
  if (!(t > 0.0)) return {};
  const double x = origin.x() + t * direction.x(), y = origin.y() + t * direction.y();
  if (!(std::abs(x) <= half.x() && std::abs(y) <= half.y())) return {};
  return {t, 0};
}

/// Smaller positive root of a t^2 + 2 b t + c = 0 from outside (c > 0); infinite if there is none.
inline double nearer_root(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0.0) || c <= 0.0 || b >= 0.0) return std::numeric_limits<double>::infinity();
  // The form of the smaller root without cancellation.
  return c / (-b + std::sqrt(discriminant));
}

inline Intersection intersect_cylinder(const Eigen::Vector3d& half, const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction) {
  const double a = direction.x() * direction.x() + direction.y() * direction.y();
  const double b = origin.x() * direction.x() + origin.y() * direction.y();
  const double c = origin.x() * origin.x() + origin.y() * origin.y() - half.x() * half.x();
  const double side = nearer_root(a, b, c);
  if (std::abs(origin.z() + side * direction.z()) <= half.z()) return {side, 0};
  if (direction.z() == 0.0) return {};
  const double cap = ((direction.z() > 0.0 ? -half.z() : half.z()) - origin.z()) / direction.z();
  if (!(cap > 0.0)) return {};
  const double x = origin.x() + cap * direction.x(), y = origin.y() + cap * direction.y();
  if (x * x + y * y > half.x() * half.x()) return {};
  return {cap, direction.z() > 0.0 ? 2 : 1};
}

inline Intersection intersect_sphere(const Eigen::Vector3d& half, const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction) {
  return {nearer_root(direction.squaredNorm(), origin.dot(direction), origin.squaredNorm() - half.x() * half.x()), 0};
}

}  // namespace detail

/// `inverse_in_world`: detail::inverse_of(direction_in_world), common to many solids.
inline Intersection intersect(const Primitive& primitive, const Eigen::Vector3d& origin_in_local,
                              const Eigen::Vector3d& direction_in_world, const Eigen::Vector3d& inverse_in_world) {
  if (primitive.aligned && primitive.shape == Shape::box)
    return detail::intersect_box(primitive.half, origin_in_local, inverse_in_world);
  const Eigen::Vector3d direction = to_local(primitive, direction_in_world);
  switch (primitive.shape) {
    case Shape::box:
      return detail::intersect_box(primitive.half, origin_in_local, detail::inverse_of(direction));
    case Shape::quad:
      return detail::intersect_quad(primitive.half, origin_in_local, direction);
    case Shape::cylinder:
      return detail::intersect_cylinder(primitive.half, origin_in_local, direction);
    case Shape::sphere:
      return detail::intersect_sphere(primitive.half, origin_in_local, direction);
  }
  return {};
}

inline Intersection intersect(const Primitive& primitive, const Eigen::Vector3d& origin_in_local,
                              const Eigen::Vector3d& direction_in_world) {
  return intersect(primitive, origin_in_local, direction_in_world, detail::inverse_of(direction_in_world));
}

}  // namespace rastro
