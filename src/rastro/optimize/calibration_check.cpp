// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/calibration_check.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace rastro {
namespace {

constexpr int unknowns = RayCorrection::count;
constexpr double least_depth = 1e-6;
constexpr std::ptrdiff_t least_views = 5;
// Tighter than in refinement: the residuals of slightly slipping tracks resemble another lens.
constexpr double huber_px = 0.3;
using Matrix26 = Eigen::Matrix<double, 2, 6>;
using Matrix25 = Eigen::Matrix<double, 2, unknowns>;

/// Normal equations of cameras and correction, points eliminated one by one.
class Normal {
 public:
  explicit Normal(const RefinementWindow& window)
      : window_(window), cameras_(6 * static_cast<Eigen::Index>(window.camera_from_world.size())) {
    all_.setZero(cameras_ + unknowns, cameras_ + unknowns);
    right_.setZero(cameras_ + unknowns);
    const auto& seen = window.observations;
    for (std::size_t begin = 0; begin < seen.size();) {
      std::size_t end = begin;
      while (end < seen.size() && seen[end].point == seen[begin].point) ++end;
      if (static_cast<std::ptrdiff_t>(end - begin) >= least_views) add_point(begin, end);
      begin = end;
    }
  }

  RayCorrection eliminate() const {
    RayCorrection found;
    const Eigen::Index n = cameras_;
    // The world's frame and the scale are free. The right-hand side has no component along them; damping keeps them
    // fixed.
    Eigen::MatrixXd poses = all_.topLeftCorner(n, n);
    poses.diagonal().array() *= 1.0 + 1e-6;
    poses.diagonal().array() += 1e-9;
    const Eigen::LDLT<Eigen::MatrixXd> solver(poses);
    if (used_ == 0 || solver.info() != Eigen::Success) return found;
    const Eigen::MatrixXd across = all_.topRightCorner(n, unknowns);
    const Eigen::MatrixXd solved = solver.solve(across);
    found.information = all_.bottomRightCorner<unknowns, unknowns>() - across.transpose() * solved;
    found.right = right_.tail<unknowns>() - solved.transpose() * right_.head(n);
    if (!found.information.allFinite() || !found.right.allFinite()) return {};
    // The residual after the step.
    const double left = squares_ - right_.head(n).dot(solver.solve(right_.head(n)));
    const double freedom = std::max(1.0, 2.0 * used_ - 3.0 * points_ - static_cast<double>(n));
    const double variance = std::max(1e-4, left / freedom);
    found.information /= variance;
    found.right /= variance;
    return found;
  }

 private:
  struct Row {
    Eigen::Index index;
    Matrix26 by_camera;
    Matrix25 by_correction;
    Eigen::Matrix<double, 2, 3> by_point;
    Eigen::Vector2d error;
  };

  bool linearize(const WindowObservation& seen, Row& row) const {
    const SE3& pose = window_.camera_from_world[static_cast<std::size_t>(seen.camera)];
    const Eigen::Vector3d p = pose * window_.points[static_cast<std::size_t>(seen.point)];
    if (p.z() < least_depth) return false;
    const double f = window_.focal_px, inverse = 1.0 / p.z(), x = p.x() * inverse, y = p.y() * inverse;
    const double r2 = x * x + y * y;
    row.index = 6 * seen.camera;
    row.error = f * (Eigen::Vector2d(x, y) - seen.ray);
    Eigen::Matrix<double, 2, 3> by_translation;
    by_translation << f * inverse, 0.0, -f * x * inverse, 0.0, f * inverse, -f * y * inverse;
    Eigen::Matrix3d cross;
    cross << 0.0, -p.z(), p.y(), p.z(), 0.0, -p.x(), -p.y(), p.x(), 0.0;
    row.by_camera << by_translation, -by_translation * cross;
    row.by_point = by_translation * pose.rotation().matrix();
    row.by_correction << x, 0.0, 1.0, 0.0, x * r2, 0.0, y, 0.0, 1.0, y * r2;
    row.by_correction *= -f;
    const double norm = row.error.norm(), weight = norm <= huber_px ? 1.0 : std::sqrt(huber_px / norm);
    row.error *= weight;
    row.by_camera *= weight;
    row.by_point *= weight;
    row.by_correction *= weight;
    return true;
  }

  void add_point(std::size_t begin, std::size_t end) {
    rows_.clear();
    Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = begin; i < end; ++i) {
      Row row;
      if (!linearize(window_.observations[i], row)) continue;
      normal += row.by_point.transpose() * row.by_point;
      right -= row.by_point.transpose() * row.error;
      rows_.push_back(row);
    }
    const Eigen::Matrix3d inverse = normal.inverse();
    Eigen::Matrix<double, unknowns, 3> correction_by_point = Eigen::Matrix<double, unknowns, 3>::Zero();
    for (const Row& row : rows_) correction_by_point += row.by_correction.transpose() * row.by_point;
    for (const Row& row : rows_) add_row(row, correction_by_point, inverse, right);
    all_.bottomRightCorner<unknowns, unknowns>() -= correction_by_point * inverse * correction_by_point.transpose();
    right_.tail<unknowns>() -= correction_by_point * inverse * right;
    squares_ -= right.dot(inverse * right);
    ++points_;
  }

  void add_row(const Row& row, const Eigen::Matrix<double, unknowns, 3>& correction_by_point,
               const Eigen::Matrix3d& inverse, const Eigen::Vector3d& right) {
    const Eigen::Matrix<double, 6, 3> scaled = row.by_camera.transpose() * row.by_point * inverse;
    all_.block<6, 6>(row.index, row.index) += row.by_camera.transpose() * row.by_camera;
    for (const Row& other : rows_)
      all_.block<6, 6>(row.index, other.index) -= scaled * (other.by_point.transpose() * other.by_camera);
    all_.block<6, unknowns>(row.index, cameras_) +=
        row.by_camera.transpose() * row.by_correction - scaled * correction_by_point.transpose();
    all_.bottomRightCorner<unknowns, unknowns>() += row.by_correction.transpose() * row.by_correction;
    right_.segment<6>(row.index) -= row.by_camera.transpose() * row.error + scaled * right;
    right_.tail<unknowns>() -= row.by_correction.transpose() * row.error;
    squares_ += row.error.squaredNorm();
    ++used_;
  }

  const RefinementWindow& window_;
  Eigen::Index cameras_;
  Eigen::MatrixXd all_;
  Eigen::VectorXd right_;
  std::vector<Row> rows_;
  double squares_ = 0.0;
  int used_ = 0, points_ = 0;
};

}  // namespace

RayCorrection ray_correction(const RefinementWindow& window) { return Normal(window).eliminate(); }

void CalibrationCheck::add(const RefinementWindow& window) {
  if (tolerance_ <= 0.0) return;
  const RayCorrection found = ray_correction(window);
  if (found.information.isZero(0.0)) return;
  ++windows_;
  const RayCorrection::Matrix unknown = RayCorrection::Matrix::Identity();
  explained_ += found.right.dot((found.information + unknown).inverse() * found.right);
  sum_.information += found.information;
  sum_.right += found.right;
  // Keeps unobserved parameters solvable: their standard deviation is at most 1.
  const RayCorrection::Matrix covariance = (sum_.information + unknown).inverse();
  estimate_.value = covariance * sum_.right;
  // Windows that contradict each other more than their covariance allows (rolling shutter, moving objects) lower the
  // certainty.
  scatter_ = std::max(
      1.0, std::max(0.0, explained_ - sum_.right.dot(estimate_.value)) / (unknowns * std::max(1, windows_ - 1)));
  estimate_.sigma = (scatter_ * covariance.diagonal().cwiseMax(0.0)).cwiseSqrt();
}

CalibrationCheck::Scale CalibrationCheck::scale() const {
  Eigen::Matrix<double, unknowns, unknowns - 1> from_fewer = Eigen::Matrix<double, unknowns, unknowns - 1>::Zero();
  from_fewer(RayCorrection::scale_x, 0) = from_fewer(RayCorrection::scale_y, 0) = 1.0;
  for (int i = RayCorrection::shift_x; i < unknowns; ++i) from_fewer(i, i - 1) = 1.0;
  const RayCorrection::Matrix information = sum_.information + RayCorrection::Matrix::Identity();
  const Eigen::Matrix<double, unknowns - 1, unknowns - 1> covariance =
      (from_fewer.transpose() * information * from_fewer).inverse();
  const double value = covariance.row(0).dot(from_fewer.transpose() * sum_.right);
  return {value, std::sqrt(scatter_ * std::max(0.0, covariance(0, 0)))};
}

bool CalibrationCheck::is_off(int index) const {
  constexpr double sure = 4.0;
  const double size = std::abs(estimate_.value[index]);
  return size > tolerance_ && size > sure * estimate_.sigma[index];
}

bool CalibrationCheck::doubtful() const {
  constexpr int least_windows = 3;
  if (tolerance_ <= 0.0 || windows_ < least_windows) return false;
  for (int i = 0; i < unknowns; ++i) {
    if (is_off(i)) return true;
  }
  return false;
}

std::string CalibrationCheck::detail(double focal_px) const {
  const auto& v = estimate_.value;
  std::string better;
  const auto say = [&](int index, const std::string& text) {
    if (is_off(index)) better += (better.empty() ? "" : ", ") + text;
  };
  say(RayCorrection::scale_x, fmt::format("fx about {:.2f} times as long", 1.0 / std::max(0.1, 1.0 + v[0])));
  say(RayCorrection::scale_y, fmt::format("fy about {:.2f} times as long", 1.0 / std::max(0.1, 1.0 + v[1])));
  say(RayCorrection::shift_x, fmt::format("cx about {:+.0f} px", -v[2] * focal_px));
  say(RayCorrection::shift_y, fmt::format("cy about {:+.0f} px", -v[3] * focal_px));
  say(RayCorrection::radial, "a different radial distortion");
  return fmt::format("points over {} windows of keyframes fit better with {}; check the calibration", windows_, better);
}

}  // namespace rastro
