// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/feature/descriptor_extractor.h"

namespace rastro {

struct DescriptorMatchOptions {
  double max_ratio = 0.8;  ///< The nearest is at most this share as far as the second nearest (Lowe 2004); 1: no test.
  bool mutual = true;      ///< Each is the other's nearest.
  double max_distance = std::numeric_limits<double>::infinity();  ///< In the descriptors' unit, or bits.
};

struct DescriptorMatch {
  std::uint32_t first = 0, second = 0;  ///< Indices of keypoints.
  float distance = 0.0F;                ///< Euclidean, or differing bits.
};

/// Matches of `first` to `second` by comparing all with all, in the order of `first`; of equal distances the smaller
/// index wins. A keypoint of `second` may be matched twice only without the mutual test. Descriptors must be of one
/// kind, else Error. The result does not depend on the pool.
std::vector<DescriptorMatch> match_descriptors(const Features& first, const Features& second,
                                               const DescriptorMatchOptions& options, TaskPool* pool = nullptr);

}  // namespace rastro
