// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/feature/descriptor_extractor.h"

namespace rastro {

struct DescriptorMatchOptions {
  double max_ratio = 0.8;  ///< Ratio test: nearest / second-nearest distance, at most (Lowe 2004); 1: no test.
  bool mutual = true;      ///< Each is the other's nearest.
  double max_distance = std::numeric_limits<double>::infinity();  ///< In the descriptors' unit, or bits.
};

struct DescriptorMatch {
  std::uint32_t first = 0, second = 0;  ///< Indices of keypoints.
  float distance = 0.0F;                ///< Euclidean, or differing bits.
};

/// Brute-force matches of `first` to `second`, in the order of `first`; of equal distances the smaller index wins.
/// Without the mutual test a keypoint of `second` may be matched twice. Throws Error for descriptors of different
/// kinds. The result does not depend on the pool.
std::vector<DescriptorMatch> match_descriptors(const Features& first, const Features& second,
                                               const DescriptorMatchOptions& options, TaskPool* pool = nullptr);

}  // namespace rastro
