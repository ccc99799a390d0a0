// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/map_uncertainty.h"

namespace rastro {

Matrix6d MapUncertainty::of_pose(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& tracked) const {
  const auto found = parts_.find(part);
  if (found == parts_.end()) return tracked;
  // A rotation of the part moves what is seen from it.
  Matrix6d lever = Matrix6d::Identity();
  lever.topRightCorner<3, 3>() = -hat(position - found->second.position);
  const Matrix6d sum = lever * found->second.covariance * lever.transpose() + tracked;
  return 0.5 * (sum + sum.transpose());
}

void MapUncertainty::set(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& covariance) {
  parts_.insert_or_assign(part, Entry{position, covariance});
}

void MapUncertainty::reduce(std::int64_t part, const Eigen::Vector3d& position, const Matrix6d& covariance) {
  const auto found = parts_.find(part);
  if (found != parts_.end() && covariance.trace() < found->second.covariance.trace())
    found->second = {position, covariance};
}

}  // namespace rastro
