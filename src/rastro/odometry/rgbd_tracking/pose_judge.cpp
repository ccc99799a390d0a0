// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/pose_judge.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/odometry/rgbd_tracking/feature_noise.h"

namespace rastro {
namespace {

// Of the image with features, the part that must fit, and the part above which the features alone say how certain they
// are.
constexpr double least_fit = 1.0 / 3.0, most_fit = 0.5;
// Meters and radians: a pose less certain is lost.
constexpr double lost_sigma = 0.2;
// Inflation of the covariance: errors of neighbors are correlated, and a map has a common error; the model has
// neither.
constexpr double covariance_factor = 4.0;

/// Share of the features or of the image that fits, whichever is smaller.
double certain_share(const RgbdFollow& result) {
  return std::min(static_cast<double>(result.inliers) / std::max(1, result.points), result.inlier_share);
}

/// Variance factor of a pose that most features or most of the image contradict: something large moves, and the pose
/// may follow it.
double contradiction(const RgbdFollow& result, int min_points) {
  if (result.points < min_points) return 1.0;
  constexpr double enough = 0.4, least = 0.1;
  return std::pow(enough / std::clamp(certain_share(result), least, enough), 3);
}

double largest_sigma(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()(5)));
}

/// Share of the common error that the newest reference does not have: it moves with the camera, and the same rays and
/// depths have the same error.
double unshared_error(const PoseSolution& solution, const Reference& newest) {
  constexpr double least = 0.1;
  const SE3 motion = newest.world_from_camera.inverse() * solution.world_from_camera;
  return std::clamp(motion.rotation().log().norm() + motion.translation().norm() / newest.median_depth, least, 1.0);
}

}  // namespace

bool PoseJudge::features_fit(const RgbdFollow& result) const {
  return result.inliers >= options_.min_points && result.inlier_share >= least_fit;
}

PoseJudge::ExcessVariance PoseJudge::excess_variance(const std::vector<PointMeasurement>& measured,
                                                     const PoseSolution& solution, double noise_factor) const {
  if (static_cast<int>(measured.size()) < options_.min_points) return {};
  // Where most contradict the pose, drift is no excuse.
  const double undrifted = options_.pixel_sigma / focal_px_, learned = noise_factor * noise_factor;
  return {std::max(1.0, learned * variance_ratio(measured, solution.by_points_alone())),
          std::max(1.0, variance_ratio(measured, solution.world_from_camera, undrifted)), learned};
}

bool PoseJudge::judge(const PoseSolution& solution, const SurfaceMatch& match, const Reference& newest,
                      const ExcessVariance& excess, RgbdFollow& result) const {
  if (!features_fit(result) && !match.fits()) return false;
  const Matrix6d information = solution.shared_points.information + solution.others.information;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(information);
  const double sigma = 1.0 / std::sqrt(std::max(eigen.eigenvalues()(0), 1e-12));
  if (!(sigma <= lost_sigma)) return false;
  const double factor = certain_share(result) >= most_fit ? excess.of_features : excess.of_all;
  // What makes features worse than set makes surfaces worse, too.
  PoseSolution as_set = solution;
  as_set.points.information *= excess.learned;
  result.covariance = covariance_factor * factor * contradiction(result, options_.min_points) *
                      as_set.information_of_motion(unshared_error(solution, newest)).inverse();
  result.world_from_camera = solution.world_from_camera;
  result.surface_points = match.fitting;
  const Vector6d texture = solution.shared_points.information.diagonal();
  result.texture_share = (texture.array() / information.diagonal().array()).mean();
  grade(sigma, factor, result);
  return true;
}

/// `sigma`: of the static scene alone; the covariance counts with what contradicts it.
void PoseJudge::grade(double sigma, double excess, RgbdFollow& result) const {
  const double moved_sigma = largest_sigma(result.covariance), larger = std::max(sigma, moved_sigma);
  result.state = larger > options_.weak_sigma ? OdometryState::weak : OdometryState::tracking;
  if (sigma > options_.weak_sigma || !features_fit(result)) {
    result.reason = OdometryReason::too_few_points;
    result.detail = fmt::format("{} features, {} matching blocks of surface; standard deviation {:.3f} m or rad",
                                result.inliers, result.surface_points, larger);
  } else if (moved_sigma > options_.weak_sigma) {
    result.reason = OdometryReason::few_inliers;
    result.detail =
        fmt::format("features disagree, errors {:.0f} times their noise; standard deviation {:.3f} m or rad",
                    std::sqrt(excess), moved_sigma);
  }
}

}  // namespace rastro
