// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "rastro/odometry/features/window_refinement.h"

namespace rastro {

/// How the given calibration would have to be changed to fit the motion it shows: the normal equations of the five
/// numbers of `Index`, everything else eliminated, in units of the errors' variance. A point at (x, y) of the
/// normalised image plane is seen where it should be at x + stretch_x x + shift_x + radial x r^2, and so in y.
struct RayCorrection {
  enum Index { stretch_x, stretch_y, shift_x, shift_y, radial, count };
  using Vector = Eigen::Matrix<double, count, 1>;
  using Matrix = Eigen::Matrix<double, count, count>;
  Matrix information = Matrix::Zero();
  Vector right = Vector::Zero();
};

/// What a refined window says: one Gauss-Newton step of a bundle adjustment whose calibration is free too (Triggs et
/// al. 2000, section 6). Only points that five cameras see count: a shorter way bends to any calibration. All zero
/// where there are none, or where nothing can be solved.
RayCorrection ray_correction(const RefinementWindow& window);

/// Sums up what window after window says of the calibration. A straight way does not show a wrong focal length (depth
/// takes it up): then the correction is not known well, and nothing is said.
class CalibrationCheck {
 public:
  /// `tolerance`: share of the focal length by which any of the five may be off; 0: no check.
  explicit CalibrationCheck(double tolerance) : tolerance_(tolerance) {}

  void add(const RefinementWindow& window);

  struct Estimate {
    RayCorrection::Vector value = RayCorrection::Vector::Zero();
    RayCorrection::Vector sigma = RayCorrection::Vector::Ones();
  };
  const Estimate& estimate() const { return estimate_; }
  /// Whether a number is off by more than the tolerance, surely, and over several windows.
  bool doubtful() const;
  /// What would fit better, one short clause.
  std::string detail(double focal_px) const;

 private:
  bool is_off(int index) const;

  double tolerance_;
  int windows_ = 0;
  double explained_ = 0.0;  ///< Sum over windows of what each one's own correction takes off its squared errors.
  RayCorrection sum_;
  Estimate estimate_;
};

}  // namespace rastro
