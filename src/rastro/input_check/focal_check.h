// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/input_check/depth_focal.h"
#include "rastro/input_check/input_warning.h"
#include "rastro/input_check/tracked_window.h"
#include "rastro/optimize/calibration_check.h"

namespace rastro {

/// Compares the calibrated focal length with multiples of it: how well does each explain the motion of features? And,
/// where features have depth, with the one that fits both. A straight trajectory says nothing, and neither does a
/// vehicle that hardly turns.
class FocalCheck {
 public:
  explicit FocalCheck(const std::optional<Camera>& camera);

  /// Adds a warning to `found` once another focal length is surely better.
  /// `trusts_depth`: nothing else was told about the depth or the pair.
  void add(const TrackedWindow& window, bool trusts_depth, InputWarnings& found);

 private:
  static constexpr std::array<double, 5> factors = {0.5, 0.7, 1.0, 1.4, 2.0};
  using Residuals = std::array<double, factors.size()>;

  std::optional<Residuals> residuals_of(const TrackedWindow& window) const;
  void judge(InputWarnings& found);
  void compare_with_depth(const TrackedWindow& window, InputWarnings& found);
  void adjust(const TrackedWindow& window, InputWarnings& found);

  /// Sums over the windows with depth.
  struct ByDepth {
    int windows = 0;
    double weights = 0.0, sum = 0.0, squares = 0.0;
    void add(const FocalFit& fit);
    FocalFit mean() const;
  };

  std::optional<Camera> camera_;
  ByDepth by_depth_;
  CalibrationCheck adjustment_;
  bool said_ = false;
  std::vector<Residuals> windows_;
};

}  // namespace rastro
