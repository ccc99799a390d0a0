// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace rastro {

/// What is known of the ratio of two keyframes' scales.
struct ScaleLink {
  std::size_t a = 0, b = 0;
  double variance = 1.0;  ///< Of the logarithm of the ratio; > 0.
};

/// Variance of the logarithm of each keyframe's scale relative to the mean over all that links connect it with: of a
/// map whose scale is arbitrary, nothing else is uncertain. 0 for a keyframe without links. These are the marginals of
/// a pose graph of scales alone.
std::vector<double> scale_variances(std::size_t keyframes, const std::vector<ScaleLink>& links);

}  // namespace rastro
