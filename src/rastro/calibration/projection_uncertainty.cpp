// SPDX-License-Identifier: Apache-2.0
#include "rastro/calibration/projection_uncertainty.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace rastro {
namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

ImageMap empty_map(int width, int height, int columns) {
  ImageMap map;
  map.columns = columns;
  map.rows = std::max(1, columns * height / std::max(1, width));
  map.values.assign(static_cast<std::size_t>(map.columns * map.rows), nan_value);
  return map;
}

SE3 camera_from_left(const BoardProblem& problem, std::size_t camera) {
  return camera == 0 ? SE3() : problem.right_from_left;
}

/// Derivative of the mean over all boards of a point's position in the camera, the point standing still in each board,
/// by all parameters (3 x n). For directions (infinitely far) translations have no part.
Eigen::Matrix3Xd mean_point_by_parameters(const BoardSolution& solution, std::size_t camera,
                                          const Eigen::Vector3d& point, bool infinite) {
  const BoardParameters& at = solution.parameters;
  Eigen::Matrix3Xd by = Eigen::Matrix3Xd::Zero(3, at.count);
  const SE3 from_left = camera_from_left(solution.problem, camera);
  const Eigen::Matrix3d rotation = from_left.rotation().matrix();
  const Eigen::Vector3d in_left =
      infinite ? Eigen::Vector3d(rotation.transpose() * point) : Eigen::Vector3d(from_left.inverse() * point);
  const double frames =
      static_cast<double>(std::count_if(at.poses.begin(), at.poses.end(), [](int p) { return p >= 0; }));
  for (std::size_t i = 0; i < at.poses.size(); ++i) {
    if (at.poses[i] < 0) continue;
    const Eigen::Vector3d translation =
        infinite ? Eigen::Vector3d::Zero() : Eigen::Vector3d(solution.problem.left_from_board[i].translation());
    by.middleCols<3>(at.poses[i]) = -rotation * hat(in_left - translation) / frames;
    if (!infinite) by.middleCols<3>(at.poses[i] + 3) = rotation / frames;
  }
  if (camera == 1 && at.right_from_left >= 0) {
    by.middleCols<3>(at.right_from_left) = -hat(rotation * in_left);
    if (!infinite) by.middleCols<3>(at.right_from_left + 3) = Eigen::Matrix3d::Identity();
  }
  return by;
}

}  // namespace

std::optional<Eigen::Matrix2Xd> projection_by_parameters(const BoardSolution& solution, std::size_t camera,
                                                         const Eigen::Vector2d& pixel, double distance) {
  const Lens& lens = solution.problem.lenses[camera];
  const auto ray = lens.unproject(pixel);
  if (!ray) return std::nullopt;
  const bool infinite = !(distance > 0.0);
  const Eigen::Vector3d point = infinite ? *ray : Eigen::Vector3d(*ray * distance);
  const auto projected = lens.project(point);
  if (!projected) return std::nullopt;
  Eigen::Matrix2Xd by = projected->by_point * mean_point_by_parameters(solution, camera, point, infinite);
  by.middleCols(solution.parameters.lenses[camera], lens.parameters.size()) += projected->by_parameters;
  return by;
}

std::optional<Eigen::Matrix2d> projection_covariance(const BoardSolution& solution, const Eigen::MatrixXd& covariance,
                                                     std::size_t camera, const Eigen::Vector2d& pixel,
                                                     double distance) {
  const auto by = projection_by_parameters(solution, camera, pixel, distance);
  if (!by) return std::nullopt;
  return *by * covariance * by->transpose();
}

Eigen::Vector2d map_pixel(const ImageMap& map, int column, int row, int width, int height) {
  return {(column + 0.5) * width / map.columns - 0.5, (row + 0.5) * height / map.rows - 0.5};
}

ImageMap projection_uncertainty(const BoardSolution& solution, const Eigen::MatrixXd& covariance, std::size_t camera,
                                int width, int height, double distance, int columns) {
  ImageMap map = empty_map(width, height, columns);
  for (int row = 0; row < map.rows; ++row)
    for (int column = 0; column < map.columns; ++column) {
      const auto of_pixel =
          projection_covariance(solution, covariance, camera, map_pixel(map, column, row, width, height), distance);
      if (!of_pixel) continue;
      const double half_trace = 0.5 * of_pixel->trace();
      const double apart = 0.5 * ((*of_pixel)(0, 0) - (*of_pixel)(1, 1)), mixed = (*of_pixel)(0, 1);
      map.values[static_cast<std::size_t>(row * columns + column)] =
          std::sqrt(std::max(0.0, half_trace + std::sqrt(apart * apart + mixed * mixed)));
    }
  return map;
}

ProjectionDifference projection_difference(const Lens& one, const Lens& other, int width, int height, int columns) {
  ProjectionDifference difference{empty_map(width, height, columns), empty_map(width, height, columns)};
  struct Cell {
    std::size_t index;
    Eigen::Vector2d pixel;
    Eigen::Vector3d ray;
  };
  std::vector<Cell> cells;
  for (int row = 0; row < difference.x.rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d pixel = map_pixel(difference.x, column, row, width, height);
      if (const auto ray = one.unproject(pixel))
        cells.push_back({static_cast<std::size_t>(row * columns + column), pixel, *ray});
    }
  SO3 rotation;
  for (int step = 0; step < 10; ++step) {
    Eigen::Matrix3d normal = 1e-12 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Cell& cell : cells) {
      const Eigen::Vector3d ray = rotation * cell.ray;
      const auto projected = other.project(ray);
      if (!projected) continue;
      const Eigen::Matrix<double, 2, 3> by = -projected->by_point * hat(ray);
      const Eigen::Vector2d error = projected->pixel - cell.pixel;
      const double weight = 1.0 / std::max(1.0, error.norm());
      normal += weight * by.transpose() * by;
      right -= weight * by.transpose() * error;
      difference.x.values[cell.index] = error.x();
      difference.y.values[cell.index] = error.y();
    }
    const Eigen::Vector3d change = normal.ldlt().solve(right);
    if (!change.allFinite() || change.norm() < 1e-10) break;
    rotation = SO3::exp(change) * rotation;
  }
  return difference;
}

}  // namespace rastro
