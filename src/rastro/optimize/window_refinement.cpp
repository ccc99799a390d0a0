// SPDX-License-Identifier: Apache-2.0
#include "rastro/optimize/window_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix63 = Eigen::Matrix<double, 6, 3>;
constexpr double least_depth = 1e-6;
constexpr double behind = 1e9;

/// Residual and Jacobians of one observation, by the camera's left increment (translation, rotation) and by the point.
struct Linearized {
  Eigen::Vector2d error;
  Eigen::Matrix<double, 2, 6> by_camera;
  Eigen::Matrix<double, 2, 3> by_point;
  double weight = 0.0;
  bool valid = false;
};

/// A pose as its matrix: cheaper to use for many points than the quaternion.
struct CameraMatrix {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

Linearized linearize(const CameraMatrix& camera_from_world, const Eigen::Vector3d& point, const Eigen::Vector2d& ray,
                     double focal, double huber) {
  Linearized out;
  const Eigen::Vector3d p = camera_from_world.rotation * point + camera_from_world.translation;
  if (p.z() < least_depth) return out;
  const double inverse = 1.0 / p.z(), x = p.x() * inverse, y = p.y() * inverse;
  out.error = focal * (Eigen::Vector2d(x, y) - ray);
  Eigen::Matrix<double, 2, 3> by_translation;
  by_translation << focal * inverse, 0.0, -focal * x * inverse, 0.0, focal * inverse, -focal * y * inverse;
  out.by_camera.leftCols<3>() = by_translation;
  out.by_camera.rightCols<3>() << -focal * x * y, focal * (1.0 + x * x), -focal * y,  //
      -focal * (1.0 + y * y), focal * x * y, focal * x;
  out.by_point = by_translation * camera_from_world.rotation;
  const double norm = out.error.norm();
  out.weight = norm <= huber ? 1.0 : huber / norm;
  out.valid = true;
  return out;
}

double huber_cost(double error, double huber) {
  return error <= huber ? error * error : 2.0 * huber * error - huber * huber;
}

double cost_of(const RefinementWindow& window, double huber) {
  double cost = 0.0;
  for (const WindowObservation& seen : window.observations) {
    const double error =
        reprojection_error_px(window.camera_from_world[static_cast<std::size_t>(seen.camera)],
                              window.points[static_cast<std::size_t>(seen.point)], seen.ray, window.focal_px);
    cost += huber_cost(std::min(error, 1e3), huber);
  }
  return cost;
}

/// The normal equations with the points eliminated, and what back-substitution of the points needs.
class Schur {
 public:
  Schur(const RefinementWindow& window, const std::vector<int>& indices, int free_cameras, double huber, double damping)
      : window_(window), indices_(indices) {
    blocks_.assign(static_cast<std::size_t>(free_cameras) * static_cast<std::size_t>(free_cameras), Matrix6::Zero());
    right_.setZero(6 * free_cameras);
    for (const SE3& pose : window.camera_from_world) cameras_.push_back({pose.rotation().matrix(), pose.translation()});
    const auto& seen = window.observations;
    for (std::size_t begin = 0; begin < seen.size();) {
      std::size_t end = begin;
      while (end < seen.size() && seen[end].point == seen[begin].point) ++end;
      add_point(begin, end, huber, damping);
      begin = end;
    }
    assemble(free_cameras, damping);
  }

  /// Steps of the cameras, six numbers each, then of the points; false if the system cannot be solved.
  bool solve(Eigen::VectorXd& camera_steps, std::vector<Eigen::Vector3d>& point_steps) const {
    camera_steps = Eigen::VectorXd::Zero(right_.size());
    if (right_.size() > 0) {
      const Eigen::LDLT<Eigen::MatrixXd, Eigen::Lower> solver(reduced_);
      if (solver.info() != Eigen::Success) return false;
      camera_steps = solver.solve(right_);
      if (!camera_steps.allFinite()) return false;
    }
    point_steps.assign(window_.points.size(), Eigen::Vector3d::Zero());
    for (const Point& point : eliminated_) {
      Eigen::Vector3d right = point.right;
      for (std::size_t k = point.begin; k < point.end; ++k) {
        right -= links_[k].by_both.transpose() * camera_steps.segment<6>(6 * links_[k].index);
      }
      point_steps[static_cast<std::size_t>(point.index)] = point.inverse * right;
    }
    return true;
  }

 private:
  struct Link {
    int index;
    Matrix63 by_both;
  };
  struct Point {
    int index;
    std::size_t begin, end;
    Eigen::Matrix3d inverse;
    Eigen::Vector3d right;
  };

  /// The lower half, row by row of cameras.
  Matrix6& block(int row, int column) { return blocks_[static_cast<std::size_t>(row * (row + 1) / 2 + column)]; }

  void assemble(int free_cameras, double damping) {
    reduced_.setZero(6 * free_cameras, 6 * free_cameras);
    for (int row = 0; row < free_cameras; ++row) {
      for (int column = 0; column <= row; ++column) reduced_.block<6, 6>(6 * row, 6 * column) = block(row, column);
    }
    reduced_.diagonal() *= 1.0 + damping;
  }

  void add_point(std::size_t begin, std::size_t end, double huber, double damping) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Point point{window_.observations[begin].point, links_.size(), links_.size(), {}, Eigen::Vector3d::Zero()};
    for (std::size_t i = begin; i < end; ++i) {
      const WindowObservation& seen = window_.observations[i];
      const Linearized l =
          linearize(cameras_[static_cast<std::size_t>(seen.camera)],
                    window_.points[static_cast<std::size_t>(seen.point)], seen.ray, window_.focal_px, huber);
      if (!l.valid) continue;
      normal += l.weight * l.by_point.transpose() * l.by_point;
      point.right -= l.weight * l.by_point.transpose() * l.error;
      const int index = indices_[static_cast<std::size_t>(seen.camera)];
      if (index < 0) continue;
      const Eigen::Matrix<double, 6, 2> weighted = l.weight * l.by_camera.transpose();
      block(index, index).noalias() += weighted * l.by_camera;
      right_.segment<6>(6 * index).noalias() -= weighted * l.error;
      links_.push_back({index, weighted * l.by_point});
    }
    normal.diagonal() *= 1.0 + damping;
    normal.diagonal().array() += 1e-9;
    point.inverse = normal.inverse();
    point.end = links_.size();
    for (std::size_t a = point.begin; a < point.end; ++a) {
      const Matrix63 scaled = links_[a].by_both * point.inverse;
      right_.segment<6>(6 * links_[a].index) -= scaled * point.right;
      for (std::size_t b = point.begin; b < point.end; ++b) {
        // The solver reads only the lower half.
        if (links_[b].index <= links_[a].index)
          block(links_[a].index, links_[b].index).noalias() -= scaled * links_[b].by_both.transpose();
      }
    }
    eliminated_.push_back(point);
  }

  const RefinementWindow& window_;
  const std::vector<int>& indices_;
  std::vector<CameraMatrix> cameras_;
  std::vector<Matrix6> blocks_;
  Eigen::MatrixXd reduced_;
  Eigen::VectorXd right_;
  std::vector<Link> links_;
  std::vector<Point> eliminated_;
};

}  // namespace

double reprojection_error_px(const SE3& camera_from_world, const Eigen::Vector3d& point, const Eigen::Vector2d& ray,
                             double focal_px) {
  const Eigen::Vector3d p = camera_from_world * point;
  if (p.z() < least_depth) return behind;
  return focal_px * (p.head<2>() / p.z() - ray).norm();
}

double refine_window(RefinementWindow& window, const RefinementOptions& options) {
  std::vector<int> indices(window.camera_from_world.size(), -1);
  int free_cameras = 0;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (window.fixed[i] == 0) indices[i] = free_cameras++;
  }
  double damping = 1e-4, cost = cost_of(window, options.huber_px);
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const Schur schur(window, indices, free_cameras, options.huber_px, damping);
    Eigen::VectorXd camera_steps;
    std::vector<Eigen::Vector3d> point_steps;
    if (!schur.solve(camera_steps, point_steps)) break;
    RefinementWindow moved = window;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] < 0) continue;
      const Eigen::Matrix<double, 6, 1> step = camera_steps.segment<6>(6 * indices[i]);
      const SO3 rotation = SO3::exp(step.tail<3>());
      const SE3& before = window.camera_from_world[i];
      moved.camera_from_world[i] = SE3(rotation * before.rotation(), rotation * before.translation() + step.head<3>());
    }
    for (std::size_t i = 0; i < window.points.size(); ++i) moved.points[i] += point_steps[i];
    const double moved_cost = cost_of(moved, options.huber_px);
    if (!(moved_cost < cost)) {
      damping *= 10.0;
      continue;
    }
    const bool done = cost - moved_cost < 1e-4 * cost;
    window = std::move(moved);
    cost = moved_cost;
    damping = std::max(1e-8, 0.1 * damping);
    if (done) break;
  }
  double squares = 0.0;
  for (const WindowObservation& seen : window.observations) {
    const double error =
        reprojection_error_px(window.camera_from_world[static_cast<std::size_t>(seen.camera)],
                              window.points[static_cast<std::size_t>(seen.point)], seen.ray, window.focal_px);
    squares += std::min(error, 1e3) * std::min(error, 1e3);
  }
  return std::sqrt(squares / std::max(1.0, static_cast<double>(window.observations.size())));
}

}  // namespace rastro
