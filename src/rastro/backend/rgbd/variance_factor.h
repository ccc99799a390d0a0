// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace rastro {

/// How large the squared residuals of adjustments are, in units of the variances that were assumed: the a posteriori
/// variance factor (Förstner and Wrobel 2016, "Photogrammetric Computer Vision", section 4.2.3). Noise differs from
/// camera to camera by more than any assumption holds; residuals show it. Constraints of one keyframe share its errors,
/// which their residuals do not show: the factor is larger by a constant, and that constant until there are residuals.
class VarianceFactor {
 public:
  /// `redundancy`: residuals minus unknowns.
  void add(double squared_sigmas, double redundancy);
  double value() const;

 private:
  double squared_ = 0.0, redundancy_ = 0.0;
};

}  // namespace rastro
