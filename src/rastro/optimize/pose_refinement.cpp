// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/pose_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/math/robust_kernel.h"

namespace rastro {
namespace {

constexpr double least_depth = 1e-9;
/// Squared sigmas of a point behind the camera.
constexpr double behind = 1e8;

struct Normal {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d right = Vector6d::Zero();
  double cost = 0.0;
};

class PoseProblem {
 public:
  PoseProblem(std::span<const PoseObservation> observations, const PoseRefinementOptions& options)
      : observations_(observations),
        options_(options),
        mono_{std::sqrt(options.chi2_mono)},
        stereo_{std::sqrt(options.chi2_stereo)},
        squared_(observations.size()),
        use_(observations.size(), 1) {
    const auto is_uncertain = [](const PoseObservation& seen) { return seen.point_covariance != nullptr; };
    if (std::any_of(observations.begin(), observations.end(), is_uncertain)) weights_.resize(observations.size());
  }

  /// Weighs uncertain points as they are seen from this pose. Not in every step: there moving away from the points,
  /// which makes them more certain, or toward them would be worth something in itself.
  void weigh_from(const SE3& pose) {
    if (weights_.empty()) return;
    const Eigen::Matrix3d rotation = pose.rotation().matrix();
    for (std::size_t i = 0; i < observations_.size(); ++i)
      weights_[i] = weight_of(observations_[i], rotation * observations_[i].point + pose.translation(), rotation);
  }

  /// Normal equations for a motion of the camera frame from the left, over the observations in use.
  Normal at(const SE3& pose, bool robust) {
    Normal normal;
    const Eigen::Matrix3d rotation = pose.rotation().matrix();
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      if (use_[i] == 0) continue;
      const Eigen::Vector3d p = rotation * observations_[i].point + pose.translation();
      if (!(p.z() > least_depth)) {
        normal.cost += robust ? mono_.cost(behind) : behind;
      } else if (std::isnan(observations_[i].right_x)) {
        add<2>(i, p, robust, normal);
      } else {
        add<3>(i, p, robust, normal);
      }
    }
    return normal;
  }

  /// Selects the observations that fit; returns their number.
  int judge(const SE3& pose) {
    int inliers = 0;
    const Eigen::Matrix3d rotation = pose.rotation().matrix();
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      const PoseObservation& seen = observations_[i];
      const Eigen::Vector3d p = rotation * seen.point + pose.translation();
      const double inverse = 1.0 / p.z();
      double squared = (p.head<2>() * inverse - seen.ray).squaredNorm();
      const bool stereo = !std::isnan(seen.right_x);
      if (stereo) {
        const double off = (p.x() - options_.baseline) * inverse - seen.right_x;
        squared += off * off;
      }
      squared_[i] = squared / (seen.sigma * seen.sigma);
      use_[i] = p.z() > least_depth && squared_[i] <= (stereo ? options_.chi2_stereo : options_.chi2_mono) ? 1 : 0;
      inliers += use_[i];
    }
    return inliers;
  }

  double mean_squared(int inliers) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < squared_.size(); ++i) sum += use_[i] != 0 ? squared_[i] : 0.0;
    return inliers > 0 ? sum / inliers : 0.0;
  }
  std::vector<std::uint8_t> take_inliers() { return std::move(use_); }

 private:
  /// Inverse square root of the covariance of (ray, right_x) in units of sigma: lower triangular.
  Eigen::Matrix3d weight_of(const PoseObservation& seen, const Eigen::Vector3d& p,
                            const Eigen::Matrix3d& rotation) const {
    if (seen.point_covariance == nullptr || !(p.z() > least_depth)) return Eigen::Matrix3d::Identity();
    const double unit = 1.0 / (p.z() * seen.sigma);
    Eigen::Matrix3d by_point;
    by_point << 1.0, 0.0, -p.x() / p.z(), 0.0, 1.0, -p.y() / p.z(), 1.0, 0.0, (options_.baseline - p.x()) / p.z();
    by_point = unit * by_point * rotation;
    const Eigen::Matrix3d covariance =
        Eigen::Matrix3d::Identity() + by_point * *seen.point_covariance * by_point.transpose();
    return covariance.llt().matrixL().solve(Eigen::Matrix3d::Identity());
  }

  template <int Rows>
  void add(std::size_t i, const Eigen::Vector3d& p, bool robust, Normal& normal) const {
    const PoseObservation& seen = observations_[i];
    const double inverse = 1.0 / p.z(), unit = 1.0 / seen.sigma, x = p.x() * inverse, y = p.y() * inverse;
    Eigen::Matrix<double, Rows, 6> jacobian;
    jacobian.row(0) << inverse, 0.0, -x * inverse, -x * y, 1.0 + x * x, -y;
    jacobian.row(1) << 0.0, inverse, -y * inverse, -1.0 - y * y, x * y, x;
    Eigen::Matrix<double, Rows, 1> rest;
    rest[0] = unit * (seen.ray.x() - x);
    rest[1] = unit * (seen.ray.y() - y);
    if constexpr (Rows == 3) {
      const double right_x = x - options_.baseline * inverse;
      jacobian.row(2) << inverse, 0.0, -right_x * inverse, -right_x * y, 1.0 + right_x * x, -y;
      rest[2] = unit * (seen.right_x - right_x);
    }
    jacobian *= unit;
    if (!weights_.empty()) {
      jacobian = (weights_[i].topLeftCorner<Rows, Rows>() * jacobian).eval();
      rest = (weights_[i].topLeftCorner<Rows, Rows>() * rest).eval();
    }
    const HuberKernel& kernel = Rows == 3 ? stereo_ : mono_;
    const double squared = rest.squaredNorm(), weight = robust ? kernel.weight(squared) : 1.0;
    const Eigen::Matrix<double, 6, Rows> weighted = weight * jacobian.transpose();
    normal.matrix.noalias() += weighted * jacobian;
    normal.right.noalias() += weighted * rest;
    normal.cost += robust ? kernel.cost(squared) : squared;
  }

  std::span<const PoseObservation> observations_;
  const PoseRefinementOptions& options_;
  HuberKernel mono_, stereo_;
  std::vector<double> squared_;
  std::vector<std::uint8_t> use_;
  std::vector<Eigen::Matrix3d> weights_;  ///< Empty: all points are certain.
};

/// False if the points in use do not determine the pose.
bool refine_round(PoseProblem& problem, bool robust, int iterations, SE3& pose, Normal& normal) {
  problem.weigh_from(pose);
  normal = problem.at(pose, robust);
  double damping = 0.0;
  for (int i = 0; i < iterations; ++i) {
    Matrix6d matrix = normal.matrix;
    matrix.diagonal() *= 1.0 + damping;
    const Eigen::LDLT<Matrix6d> solver(matrix);
    const double largest = solver.vectorD().cwiseAbs().maxCoeff();
    if (!(solver.vectorD().minCoeff() > 1e-13 * largest)) return false;
    const Vector6d step = solver.solve(normal.right);
    if (!step.allFinite()) return false;
    const SE3 next = SE3::exp(step) * pose;
    const Normal there = problem.at(next, robust);
    if (!(there.cost <= normal.cost)) {
      damping = std::max(1e-4, 10.0 * damping);
      continue;
    }
    const double gain = normal.cost - there.cost;
    pose = next;
    normal = there;
    damping *= 0.1;
    if (gain <= (robust ? 1e-4 : 1e-6) * normal.cost) break;
  }
  return true;
}

}  // namespace

PoseRefinement refine_pose(const SE3& camera_from_world, std::span<const PoseObservation> observations,
                           const PoseRefinementOptions& options) {
  PoseProblem problem(observations, options);
  PoseRefinement result;
  result.camera_from_world = camera_from_world;
  result.is_inlier.assign(observations.size(), 0);
  constexpr int least = 3;
  if (observations.size() < least) return result;
  SE3 pose = camera_from_world;
  Normal normal;
  int inliers = options.starts_judged ? problem.judge(pose) : 0;
  for (int round = 0; round < options.rounds; ++round) {
    if (!refine_round(problem, round < options.rounds - 2, options.iterations, pose, normal)) return result;
    inliers = problem.judge(pose);
    if (inliers < least) return result;
  }
  const Eigen::FullPivLU<Matrix6d> solver(problem.at(pose, false).matrix);
  if (!solver.isInvertible()) return result;
  result.camera_from_world = pose;
  result.covariance = solver.inverse();
  result.covariance = 0.5 * (result.covariance + result.covariance.transpose()).eval();
  result.inliers = inliers;
  result.mean_squared = problem.mean_squared(inliers);
  result.is_inlier = problem.take_inliers();
  return result;
}

}  // namespace rastro
