// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "rastro/multiview/absolute_pose.h"
#include "rastro/multiview/polynomial.h"

// Persson and Nordberg 2018. The depths L = (l1, l2, l3) along unit rays y fulfill L' Mij L = aij for each pair of
// points, with aij their squared distance. A combination of these forms without a constant that has rank two is a pair
// of planes, which leaves a quadratic for the depths.

namespace rastro {
namespace {

using Triple = Eigen::Vector3d;

struct Triangle {
  std::array<Eigen::Vector3d, 3> world, rays;
  double a12, a13, a23;  ///< Squared distances.
  double b12, b13, b23;  ///< Cosines between the rays.
};

Eigen::Matrix3d form_of(int i, int j, double cosine) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  m(i, i) = m(j, j) = 1.0;
  m(i, j) = m(j, i) = -cosine;
  return m;
}

Eigen::Matrix3d adjugate(const Eigen::Matrix3d& m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) result.row(i) = m.col((i + 1) % 3).cross(m.col((i + 2) % 3)).transpose();
  return result;
}

/// Gauss-Newton on the three squared distances, to recover the precision lost in the cubic.
Triple polished(Triple l, const Triangle& t) {
  for (int i = 0; i < 5; ++i) {
    const Triple rest(l(0) * l(0) + l(1) * l(1) - 2.0 * t.b12 * l(0) * l(1) - t.a12,
                      l(0) * l(0) + l(2) * l(2) - 2.0 * t.b13 * l(0) * l(2) - t.a13,
                      l(1) * l(1) + l(2) * l(2) - 2.0 * t.b23 * l(1) * l(2) - t.a23);
    Eigen::Matrix3d jacobian;
    jacobian << 2.0 * (l(0) - t.b12 * l(1)), 2.0 * (l(1) - t.b12 * l(0)), 0.0,  //
        2.0 * (l(0) - t.b13 * l(2)), 0.0, 2.0 * (l(2) - t.b13 * l(0)),          //
        0.0, 2.0 * (l(1) - t.b23 * l(2)), 2.0 * (l(2) - t.b23 * l(1));
    const Triple step = jacobian.inverse() * rest;
    if (!step.allFinite()) break;
    l -= step;
    if (step.norm() < 1e-14 * l.norm()) break;
  }
  return l;
}

/// The rigid motion that maps the world points to the points at their depths.
SE3 pose_of(const Triple& depths, const Triangle& t) {
  std::array<Eigen::Vector3d, 3> camera;
  for (int i = 0; i < 3; ++i) camera[static_cast<std::size_t>(i)] = depths(i) * t.rays[static_cast<std::size_t>(i)];
  const auto sides = [](const std::array<Eigen::Vector3d, 3>& points) {
    Eigen::Matrix3d m;
    m.col(0) = points[1] - points[0];
    m.col(1) = points[2] - points[0];
    m.col(2) = m.col(0).cross(m.col(1));
    return m;
  };
  const SO3 rotation = SO3::from_matrix(sides(camera) * sides(t.world).inverse());
  return SE3(rotation, camera[0] - rotation * t.world[0]);
}

/// Depths of one plane of the pair: l1 = w0 l2 + w1 l3.
void add_depths(double w0, double w1, const Triangle& t, std::vector<Triple>& out) {
  const double a = (t.a13 - t.a12) * w1 * w1 + 2.0 * t.a12 * t.b13 * w1 - t.a12;
  const double b = 2.0 * ((t.a13 - t.a12) * w0 * w1 - t.a13 * t.b12 * w1 + t.a12 * t.b13 * w0);
  const double c = (t.a13 - t.a12) * w0 * w0 - 2.0 * t.a13 * t.b12 * w0 + t.a13;
  for (const double ratio : cubic_roots(0.0, a, b, c)) {  // l3 / l2
    if (!(ratio > 0.0)) continue;
    const double square = t.a23 / (1.0 + ratio * (ratio - 2.0 * t.b23));
    if (!(square > 0.0)) continue;
    const double second = std::sqrt(square), third = ratio * second, first = w0 * second + w1 * third;
    if (first > 0.0) out.emplace_back(first, second, third);
  }
}

std::vector<Triple> depths_of(const Triangle& t) {
  const Eigen::Matrix3d m12 = form_of(0, 1, t.b12), m13 = form_of(0, 2, t.b13), m23 = form_of(1, 2, t.b23);
  const Eigen::Matrix3d d1 = m12 * t.a23 - m23 * t.a12, d2 = m13 * t.a23 - m23 * t.a13;
  const double c3 = d2.determinant(), c2 = (adjugate(d2) * d1).trace();
  const double c1 = (adjugate(d1) * d2).trace(), c0 = d1.determinant();
  std::vector<Triple> depths;
  for (const double mix : cubic_roots(c3, c2, c1, c0)) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(d1 + mix * d2);
    const Eigen::Vector3d values = eigen.eigenvalues();  // ascending; the middle one is zero
    if (!(values(2) > 0.0 && values(0) < 0.0)) continue;
    const double slope = std::sqrt(-values(0) / values(2));
    const Triple p = eigen.eigenvectors().col(2), q = eigen.eigenvectors().col(0);
    for (const double s : {slope, -slope}) {
      const Triple plane = p - s * q;
      if (std::abs(plane(0)) > 1e-12) add_depths(-plane(1) / plane(0), -plane(2) / plane(0), t, depths);
    }
    if (!depths.empty()) break;
  }
  return depths;
}

}  // namespace

std::vector<SE3> pose_from_three(std::span<const Eigen::Vector3d, 3> points_in_world,
                                 std::span<const Eigen::Vector2d, 3> points) {
  Triangle t;
  for (std::size_t i = 0; i < 3; ++i) {
    t.world[i] = points_in_world[i];
    t.rays[i] = points[i].homogeneous().normalized();
  }
  t.a12 = (t.world[0] - t.world[1]).squaredNorm();
  t.a13 = (t.world[0] - t.world[2]).squaredNorm();
  t.a23 = (t.world[1] - t.world[2]).squaredNorm();
  t.b12 = t.rays[0].dot(t.rays[1]);
  t.b13 = t.rays[0].dot(t.rays[2]);
  t.b23 = t.rays[1].dot(t.rays[2]);
  // Collinear points leave a rotation about their line undetermined.
  const double area = (t.world[1] - t.world[0]).cross(t.world[2] - t.world[0]).norm();
  if (!(area > 1e-9 * (t.a12 + t.a13 + t.a23))) return {};
  std::vector<SE3> poses;
  for (const Triple& start : depths_of(t)) {
    const Triple depths = polished(start, t);
    if (depths.allFinite() && depths.minCoeff() > 0.0) poses.push_back(pose_of(depths, t));
  }
  return poses;
}

}  // namespace rastro
