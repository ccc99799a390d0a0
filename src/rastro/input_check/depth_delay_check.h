// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <array>
#include <deque>
#include <optional>

#include "rastro/input_check/image_shift.h"
#include "rastro/input_check/input_warning.h"

namespace rastro {

/// Are image and depth of the same moment? Both move alike when the camera moves: the correlation of their shifts from
/// frame to frame is highest at the delay of the depth.
class DepthDelayCheck {
 public:
  void add(const Frame& frame, InputWarnings& found);

 private:
  static constexpr int most_lag = 10;  ///< Frames.

  struct Motion {
    TimeNs stamp = 0;
    Thumbnail image, depth;
    std::optional<Eigen::Vector2d> image_shift, depth_shift;  ///< Since the frame before; none after a gap.
  };
  /// Sums over pairs of shifts of image and depth.
  struct Correlation {
    int pairs = 0;
    Eigen::Vector2d image = Eigen::Vector2d::Zero(), depth = Eigen::Vector2d::Zero();
    double image_square = 0.0, depth_square = 0.0, product = 0.0;
    void add(const Eigen::Vector2d& image_shift, const Eigen::Vector2d& depth_shift);
    double value() const;
  };

  void judge(InputWarnings& found);

  std::int64_t frames_ = 0;
  bool said_ = false;
  double frame_s_ = 0.0;
  std::deque<Motion> recent_;  ///< The newest last.
  std::array<Correlation, 2 * most_lag + 1>
      by_lag_;  ///< Depth is that many frames later than the image, from -most_lag.
};

}  // namespace rastro
