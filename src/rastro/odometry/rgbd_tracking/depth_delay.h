// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace rastro {

/// By how much depth images are taken later than their stamps say, learned from every frame.
class DepthDelay {
 public:
  double seconds() const { return seconds_; }

  /// Takes a frame's normal equation of the delay alone: information (1/s^2) and gradient (1/s) at the present value.
  /// Returns the change.
  double learn(double information, double gradient) {
    information_ += share * information;
    const double before = seconds_;
    seconds_ = std::clamp(seconds_ + share * gradient / information_, -most_seconds, most_seconds);
    return seconds_ - before;
  }

 private:
  static constexpr double first_sigma_s = 0.02, most_seconds = 0.06;
  /// Errors of points in one frame are correlated, and so are errors of consecutive frames.
  static constexpr double share = 0.02;

  double seconds_ = 0.0;
  double information_ = 1.0 / (first_sigma_s * first_sigma_s);
};

}  // namespace rastro
