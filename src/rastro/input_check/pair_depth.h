// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "rastro/image/pyramid.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// Depth of single features by a calibrated pair.
class PairDepth {
 public:
  /// nullopt where the recording has no calibrated pair.
  static std::optional<PairDepth> of(const SourceInfo& info);

  /// In the left camera, meters, one per pixel of the left image; 0: none. `left` has klt_padding.
  std::vector<float> depths(const Pyramid& left, const GrayImage& right, const std::vector<Eigen::Vector2f>& pixels);
  /// By how much the relative error grows with the depth, 1/m.
  double error_growth() const;

 private:
  PairDepth(const Camera& left, const Camera& right, const SE3& right_from_left)
      : left_(left), right_(right), right_from_left_(right_from_left) {}

  Camera left_, right_;
  SE3 right_from_left_;
  Pyramid right_pyramid_;
};

}  // namespace rastro
