// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/edge_covariance.h"

#include <Eigen/LU>

namespace rastro {
namespace {

Vector6d common_variances(const RgbdSlamOptions& options) {
  Vector6d variances;
  variances.head<3>().setConstant(options.edge_sigma_m * options.edge_sigma_m);
  variances.tail<3>().setConstant(options.edge_sigma_rad * options.edge_sigma_rad);
  return variances;
}

}  // namespace

Matrix6d with_common_errors(Matrix6d covariance, const RgbdSlamOptions& options) {
  covariance.diagonal() += common_variances(options);
  return covariance;
}

Matrix6d without_common_errors(const Constraint& edge, const RgbdSlamOptions& options) {
  constexpr double least_share = 0.01;  // of an edge that came without them, as from a map
  Matrix6d covariance = edge.information.inverse();
  covariance.diagonal() =
      (covariance.diagonal() - common_variances(options)).cwiseMax(least_share * covariance.diagonal()).eval();
  return covariance;
}

}  // namespace rastro
