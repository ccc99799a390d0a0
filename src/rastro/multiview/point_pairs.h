// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace rastro {

/// Corresponding pixels of two images, kept as four columns so that scoring loops run over plain arrays.
struct PointPairs {
  std::vector<float> ax, ay, bx, by;

  std::size_t size() const { return ax.size(); }
  void clear() {
    for (auto* column : {&ax, &ay, &bx, &by}) column->clear();
  }
  void add(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    ax.push_back(a.x());
    ay.push_back(a.y());
    bx.push_back(b.x());
    by.push_back(b.y());
  }
  Eigen::Vector2d a(std::size_t i) const { return {static_cast<double>(ax[i]), static_cast<double>(ay[i])}; }
  Eigen::Vector2d b(std::size_t i) const { return {static_cast<double>(bx[i]), static_cast<double>(by[i])}; }
};

/// A model fitted by RANSAC. `errors` are squared, in pixels, one per pair.
template <typename Model>
struct RobustFitOf {
  Model model = Model::Identity();
  std::vector<float> squared_errors;
  int inliers = 0;
  int iterations = 0;
};
using RobustFit = RobustFitOf<Eigen::Matrix3d>;

struct RansacOptions {
  double max_error_px = 3.0;
  double confidence = 0.99;
  int max_iterations = 200;
  std::uint64_t seed = 1;
  /// Samples at least, up to max_iterations: with little parallax a sample without an outlier may still lead to a model
  /// that is far off and fits most pairs.
  int min_iterations = 1;
};

/// For calibrated views: points are normalized (x / z, y / z), and errors are in pixels of a camera of this focal
/// length.
struct CalibratedRansacOptions : RansacOptions {
  double focal_px = 500.0;
};

}  // namespace rastro
