// SPDX-License-Identifier: Apache-2.0
#include "rastro/multiview/homography_motion.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace rastro {

std::vector<SE3> motions_of_homography(const Eigen::Matrix3d& homography) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(homography, Eigen::ComputeFullV);
  const Eigen::Vector3d values = svd.singularValues();
  if (!homography.allFinite() || !(values[2] > 1e-9 * values[0])) return {};
  // In units of the middle singular value it is R + t n' with n the plane's normal divided by its distance.
  const Eigen::Matrix3d unit = homography / values[1];
  const double first = std::pow(values[0] / values[1], 2), third = std::pow(values[2] / values[1], 2);
  const double spread = first - third;
  if (!(spread > 1e-9)) return {SE3(SO3::from_matrix(unit), Eigen::Vector3d::Zero())};
  Eigen::Matrix3d v = svd.matrixV();
  if (v.determinant() < 0.0) v = -v;
  const double along = std::sqrt(std::max(0.0, 1.0 - third)), across = std::sqrt(std::max(0.0, first - 1.0));
  std::vector<SE3> motions;
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Vector3d u = (along * v.col(0) + sign * across * v.col(2)) / std::sqrt(spread);
    const Eigen::Vector3d normal = v.col(1).cross(u);
    Eigen::Matrix3d before, after;
    before << v.col(1), u, normal;
    const Eigen::Vector3d middle = unit * v.col(1), other = unit * u;
    after << middle, other, middle.cross(other);
    const SO3 rotation = SO3::from_matrix(after * before.transpose());
    const Eigen::Vector3d translation = (unit - rotation.matrix()) * normal;
    if (!(translation.norm() > 1e-12)) continue;
    for (const double direction : {1.0, -1.0}) motions.emplace_back(rotation, direction * translation.normalized());
  }
  return motions;
}

}  // namespace rastro
