// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "rastro/optimize/window_refinement.h"

namespace rastro {

/// The correction of the given calibration that fits the observed motion best: normal equations of the five parameters
/// of `Index`, all else eliminated, in units of the residuals' variance. A point predicted at (x, y) of the normalized
/// image plane is observed at x + scale_x x + shift_x + radial x r^2, and likewise in y.
struct RayCorrection {
  enum Index { scale_x, scale_y, shift_x, shift_y, radial, count };
  using Vector = Eigen::Matrix<double, count, 1>;
  using Matrix = Eigen::Matrix<double, count, count>;
  Matrix information = Matrix::Zero();
  Vector right = Vector::Zero();
};

/// Result for one refined window: a Gauss-Newton step of a bundle adjustment with free calibration (Triggs et al. 2000,
/// section 6). Only points with five observations or more count: a shorter track can be explained by any calibration.
/// All zero where there are no such points or the system cannot be solved.
RayCorrection ray_correction(const RefinementWindow& window);

/// Accumulates the calibration evidence of all windows. A straight trajectory does not constrain the focal length
/// (depth absorbs the error): then the correction is too uncertain, and nothing is reported.
class CalibrationCheck {
 public:
  /// `tolerance`: share of the focal length by which any of the five parameters may be wrong; 0 disables the check.
  explicit CalibrationCheck(double tolerance) : tolerance_(tolerance) {}

  void add(const RefinementWindow& window);

  struct Estimate {
    RayCorrection::Vector value = RayCorrection::Vector::Zero();
    RayCorrection::Vector sigma = RayCorrection::Vector::Ones();
  };
  const Estimate& estimate() const { return estimate_; }
  /// The common scale of x and y alone: value and standard deviation.
  struct Scale {
    double value = 0.0, sigma = 1.0;
  };
  Scale scale() const;
  int windows() const { return windows_; }
  /// Whether a parameter exceeds the tolerance significantly and over several windows.
  bool doubtful() const;
  /// The calibration that would fit better, in one short clause.
  std::string detail(double focal_px) const;

 private:
  bool is_off(int index) const;

  double tolerance_;
  int windows_ = 0;
  double scatter_ = 1.0;    ///< How much more the windows differ than their covariance allows, at least 1.
  double explained_ = 0.0;  ///< Sum over windows: reduction of the squared errors by each window's own correction.
  RayCorrection sum_;
  Estimate estimate_;
};

}  // namespace rastro
