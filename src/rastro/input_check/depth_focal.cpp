// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/depth_focal.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/math/se3.h"

namespace rastro {
namespace {

constexpr std::size_t least_features = 40;
constexpr int iterations = 30, unknowns = 7;
constexpr double huber = 1.5, pixel_sigma = 0.5;
constexpr double depth_sigma = 0.004;  // Of a depth, as a share; besides a part that grows with it.
constexpr double largest_log_factor = 1.2, converged = 1e-5;
constexpr double least_inlier_share = 0.5, inlier_sigmas = 4.0;

using Vector7 = Eigen::Matrix<double, unknowns, 1>;
using Matrix7 = Eigen::Matrix<double, unknowns, unknowns>;

struct Feature {
  Eigen::Vector2d first, last;  ///< Rays by the given calibration.
  double first_depth, last_depth;
};

std::vector<Feature> features_of(const TrackedWindow& window, const Camera& camera) {
  std::vector<Feature> features;
  for (const std::size_t i : window.survivors()) {
    if (!(window.start_depths[i] > 0.0F) || !(window.end_depths[i] > 0.0F)) continue;
    const auto first = camera.unproject(window.tracks[i].front().cast<double>()),
               last = camera.unproject(window.tracks[i].back().cast<double>());
    if (first && last && std::isfinite(window.start_depths[i]) && std::isfinite(window.end_depths[i]))
      features.push_back(
          {*first, *last, static_cast<double>(window.start_depths[i]), static_cast<double>(window.end_depths[i])});
  }
  return features;
}

/// The residuals of a feature, in sigmas: two of the pixel and one of the depth, by pose and logarithm of the factor.
struct Residual {
  Eigen::Vector3d error;
  Eigen::Matrix<double, 3, unknowns> jacobian;
};

class Fit {
 public:
  Fit(const std::vector<Feature>& features, double focal_px, double error_growth)
      : features_(features), focal_px_(focal_px), error_growth_(error_growth) {}

  bool solve() {
    for (int k = 0; k < iterations; ++k) {
      linearize();
      const Eigen::LDLT<Matrix7> solver(information_);
      const Vector7 step = -solver.solve(gradient_);
      if (solver.info() != Eigen::Success || !step.allFinite()) return false;
      last_from_first_ = SE3::exp(step.head<6>()) * last_from_first_;
      log_factor_ += std::clamp(step[6], -0.3, 0.3);
      if (std::abs(log_factor_) > largest_log_factor) return false;
      if (step.norm() > converged) continue;
      linearize();
      return static_cast<double>(inliers_) > least_inlier_share * static_cast<double>(features_.size());
    }
    return false;
  }

  std::optional<FocalFit> result() const {
    const double variance = std::max(1.0, squares_ / std::max(1.0, 3.0 * inliers_ - unknowns));
    const Matrix7 covariance = information_.inverse();
    if (!(covariance(6, 6) > 0.0) || !std::isfinite(covariance(6, 6))) return std::nullopt;
    return FocalFit{log_factor_, std::sqrt(variance * covariance(6, 6))};
  }

 private:
  double sigma_of(double depth) const { return depth * (depth_sigma + error_growth_ * depth); }

  std::optional<Residual> residual(const Feature& feature) const {
    const double factor = std::exp(log_factor_);
    const Eigen::Vector2d sideways = feature.first_depth / factor * feature.first;
    const Eigen::Vector3d rotated =
        last_from_first_.rotation() * Eigen::Vector3d(sideways.x(), sideways.y(), feature.first_depth);
    const Eigen::Vector3d p = rotated + last_from_first_.translation();
    if (p.z() < 0.05 * feature.first_depth) return std::nullopt;
    const double inverse = 1.0 / p.z(), by_pixel = factor * inverse * focal_px_ / pixel_sigma;
    const double z_sigma = std::hypot(sigma_of(feature.first_depth), sigma_of(feature.last_depth));
    Eigen::Matrix3d by_point;
    by_point << by_pixel, 0.0, -by_pixel * p.x() * inverse, 0.0, by_pixel, -by_pixel * p.y() * inverse, 0.0, 0.0,
        1.0 / z_sigma;
    // The first depth's error moves the pixel too.
    const Eigen::Vector2d moved =
        sigma_of(feature.first_depth) / feature.first_depth * (by_point.topRows<2>() * rotated);
    const double widened = std::sqrt(1.0 + moved.squaredNorm()), to_sigmas = focal_px_ / (pixel_sigma * widened);
    by_point.topRows<2>() /= widened;
    Residual found;
    const Eigen::Vector2d ray = factor * inverse * p.head<2>();
    found.error << to_sigmas * (ray - feature.last), (p.z() - feature.last_depth) / z_sigma;
    found.jacobian.leftCols<3>() = by_point;
    found.jacobian.middleCols<3>(3) = -by_point * hat(p);
    found.jacobian.col(6) =
        -by_point * (last_from_first_.rotation() * Eigen::Vector3d(sideways.x(), sideways.y(), 0.0));
    found.jacobian.block<2, 1>(0, 6) += to_sigmas * ray;
    return found;
  }

  void linearize() {
    information_ = 1e-9 * Matrix7::Identity();
    gradient_.setZero();
    squares_ = 0.0;
    inliers_ = 0;
    for (const Feature& feature : features_) {
      const auto found = residual(feature);
      if (!found) continue;
      const double norm = found->error.norm(), weight = norm <= huber ? 1.0 : huber / norm;
      information_ += weight * found->jacobian.transpose() * found->jacobian;
      gradient_ += weight * found->jacobian.transpose() * found->error;
      if (norm > inlier_sigmas) continue;
      squares_ += weight * norm * norm;
      ++inliers_;
    }
  }

  const std::vector<Feature>& features_;
  double focal_px_, error_growth_;
  SE3 last_from_first_;
  double log_factor_ = 0.0;
  Matrix7 information_;
  Vector7 gradient_;
  double squares_ = 0.0;
  int inliers_ = 0;
};

}  // namespace

std::optional<FocalFit> focal_from_depth(const TrackedWindow& window, const Camera& camera) {
  const std::vector<Feature> features = features_of(window, camera);
  if (features.size() < least_features) return std::nullopt;
  Fit fit(features, 0.5 * (camera.fx + camera.fy), window.depth_error_growth);
  if (!fit.solve()) return std::nullopt;
  return fit.result();
}

}  // namespace rastro
