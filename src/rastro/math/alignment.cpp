// SPDX-License-Identifier: Apache-2.0
#include "rastro/math/alignment.h"

#include <Eigen/SVD>
#include <cmath>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using Points = std::span<const Eigen::Vector3d>;

/// Below this share of the largest singular value a direction counts as degenerate.
constexpr double rank_tolerance = 1e-9;

struct Moments {
  Eigen::Vector3d target_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of target (rows) with source.
  double target_variance = 0.0;
  double source_variance = 0.0;
};

/// Points that coincide up to the rounding of their mean have no extent.
bool has_extent(double variance, const Eigen::Vector3d& mean) { return variance > 1e-26 * mean.squaredNorm(); }

Moments moments(Points target, Points source) {
  Moments result;
  const double share = 1.0 / static_cast<double>(source.size());
  for (std::size_t i = 0; i < source.size(); ++i) {
    result.target_mean += share * target[i];
    result.source_mean += share * source[i];
  }
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d from_mean = source[i] - result.source_mean;
    const Eigen::Vector3d from_target_mean = target[i] - result.target_mean;
    result.covariance += share * from_target_mean * from_mean.transpose();
    result.target_variance += share * from_target_mean.squaredNorm();
    result.source_variance += share * from_mean.squaredNorm();
  }
  if (has_extent(result.target_variance, result.target_mean) && has_extent(result.source_variance, result.source_mean))
    return result;
  // A NaN must propagate to the covariance.
  if (result.covariance.allFinite()) result.covariance.setZero();
  return result;
}

struct RotationFit {
  SO3 rotation;
  double trace = 0.0;  ///< Of the singular values with their signs.
  bool unique = false;
};

RotationFit fit_yaw(const Eigen::Matrix3d& covariance) {
  const double sine = covariance(1, 0) - covariance(0, 1);
  const double cosine = covariance(0, 0) + covariance(1, 1);
  const double scale = covariance.cwiseAbs().maxCoeff();
  const bool unique = std::hypot(sine, cosine) > rank_tolerance * scale;
  const double yaw = unique ? std::atan2(sine, cosine) : 0.0;
  return {SO3::exp({0.0, 0.0, yaw}), 0.0, unique};
}

RotationFit fit_rotation(const Eigen::Matrix3d& covariance) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs.z() = -1.0;
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  const Eigen::Vector3d& values = svd.singularValues();
  // For mirrored points with equal spread the choice of the flipped axis is ambiguous.
  const double second = values.y() + signs.z() * values.z();
  return {SO3(Eigen::Quaterniond(rotation)), values.dot(signs), second > rank_tolerance * values.x()};
}

double rmse_of(Points target, Points source, const Sim3& target_from_source) {
  double sum = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) sum += (target[i] - target_from_source * source[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(source.size()));
}

}  // namespace

std::optional<Alignment> align_points(Points target, Points source, AlignmentKind kind) {
  RASTRO_CHECK(target.size() == source.size(), "the same number of source and target points");
  if (source.empty()) return std::nullopt;
  const Moments sums = moments(target, source);
  if (!sums.covariance.allFinite() || !sums.target_mean.allFinite() || !sums.source_mean.allFinite())
    return std::nullopt;
  const RotationFit fit = kind == AlignmentKind::yaw ? fit_yaw(sums.covariance) : fit_rotation(sums.covariance);
  double scale = 1.0;
  if (kind == AlignmentKind::similarity) {
    scale = fit.trace / sums.source_variance;
    if (!(scale > 0.0) || !std::isfinite(scale)) return std::nullopt;
  }
  Alignment result;
  result.target_from_source = Sim3(scale, fit.rotation, sums.target_mean - scale * (fit.rotation * sums.source_mean));
  result.rmse = rmse_of(target, source, result.target_from_source);
  result.unique = fit.unique;
  return result;
}

}  // namespace rastro
