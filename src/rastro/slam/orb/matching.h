// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "rastro/slam/orb/feature_frame.h"

namespace rastro {

/// A landmark as a search expects it in a picture.
struct ExpectedFeature {
  std::uint32_t subject = 0;  ///< The caller's own number.
  float x = 0.0F, y = 0.0F;   ///< Ideal pixels.
  float radius = 0.0F;        ///< Half the side of the square that is searched.
  float right = 0.0F;         ///< Where the right camera should see it; NaN: unknown.
  std::uint8_t least_level = 0, most_level = 0;
  const Descriptor* descriptor = nullptr;
};

struct FeatureMatch {
  std::uint32_t subject = 0, feature = 0;
  int distance = 0;
};

struct MatchLimits {
  int max_distance = 80;
  double max_ratio = 0.9;  ///< Of the best distance to the second best.
};

/// The most similar feature for each expected one; a feature goes to the subject it is most similar to (then the
/// first). Features with `taken` (empty or one a feature) not zero are passed over. Ascending by feature.
std::vector<FeatureMatch> match_expected(const FeatureFrame& frame, const std::vector<ExpectedFeature>& expected,
                                         const MatchLimits& limits, const std::vector<std::uint8_t>& taken = {});

/// Features of two frames that are each other's most similar within `radius_px`; pairs ascend by the first.
std::vector<std::pair<std::uint32_t, std::uint32_t>> match_within(const FeatureFrame& first, const FeatureFrame& second,
                                                                  float radius_px, const MatchLimits& limits);

}  // namespace rastro
