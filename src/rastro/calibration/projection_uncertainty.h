// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/calibration/calibrate.h"

namespace rastro {

/// A grid of values over an image, row by row; NaN where there is none.
struct ImageMap {
  int columns = 0, rows = 0;
  std::vector<double> values;

  double at(int column, int row) const { return values[static_cast<std::size_t>(row * columns + column)]; }
};

/// Covariance of where a point projects that is seen at `pixel` at `distance` meters (0: infinitely far), 2x2 in square
/// pixels: by how much the projection of a point that stands still relative to the boards moves with the noise of the
/// corners. The camera's frame moves with its intrinsics, so the point is held by each board, and what the boards say
/// is averaged: "mean-pcam" of mrcal (Kogan, mrcal documentation, "Projection uncertainty",
/// https://mrcal.secretsauce.net/uncertainty.html). nullopt where the lens images no ray.
std::optional<Eigen::Matrix2d> projection_covariance(const BoardSolution& solution, const Eigen::MatrixXd& covariance,
                                                     std::size_t camera, const Eigen::Vector2d& pixel, double distance);

/// Derivative of the same projection by all parameters of the solution, 2 x BoardParameters::count.
std::optional<Eigen::Matrix2Xd> projection_by_parameters(const BoardSolution& solution, std::size_t camera,
                                                         const Eigen::Vector2d& pixel, double distance);

/// Standard deviation in its worst direction over the image, pixels.
ImageMap projection_uncertainty(const BoardSolution& solution, const Eigen::MatrixXd& covariance, std::size_t camera,
                                int width, int height, double distance, int columns = 32);

/// Position of a cell of a map in the image.
Eigen::Vector2d map_pixel(const ImageMap& map, int column, int row, int width, int height);

/// Where a point seen at each cell by lens `one` is seen by lens `other`, minus that cell, after the rotation between
/// their frames that explains the most in the image (points infinitely far): x and y, pixels.
struct ProjectionDifference {
  ImageMap x, y;
};
ProjectionDifference projection_difference(const Lens& one, const Lens& other, int width, int height, int columns = 32);

}  // namespace rastro
