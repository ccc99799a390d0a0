// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/matching.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

/// Pixels by which a place in the right picture may differ, in radii.
bool right_fits(const FeatureFrame& frame, std::uint32_t feature, const ExpectedFeature& subject) {
  const float right = frame.right_pixel(feature);
  return !(std::abs(right - subject.right) > subject.radius);
}

struct Best {
  std::int64_t feature = -1;
  int distance = 257, second = 257;

  void offer(std::uint32_t candidate, int at) {
    if (at < distance) {
      second = distance;
      distance = at;
      feature = candidate;
    } else if (at < second) {
      second = at;
    }
  }
  bool passes(const MatchLimits& limits) const {
    return feature >= 0 && distance <= limits.max_distance && distance <= limits.max_ratio * second;
  }
};

}  // namespace

std::vector<FeatureMatch> match_expected(const FeatureFrame& frame, const std::vector<ExpectedFeature>& expected,
                                         const MatchLimits& limits, const std::vector<std::uint8_t>& taken) {
  std::vector<FeatureMatch> best_of(frame.size(), FeatureMatch{0, 0, 257});
  std::vector<std::uint32_t> found;
  for (const ExpectedFeature& subject : expected) {
    frame.find(subject.x, subject.y, subject.radius, subject.least_level, subject.most_level, found);
    Best best;
    for (const std::uint32_t feature : found) {
      if ((!taken.empty() && taken[feature] != 0) || !right_fits(frame, feature, subject)) continue;
      best.offer(feature, hamming_distance(*subject.descriptor, frame.descriptor(feature)));
    }
    if (!best.passes(limits)) continue;
    const auto feature = static_cast<std::uint32_t>(best.feature);
    if (best.distance < best_of[feature].distance) best_of[feature] = {subject.subject, feature, best.distance};
  }
  std::erase_if(best_of, [](const FeatureMatch& match) { return match.distance > 256; });
  return best_of;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> match_within(const FeatureFrame& first, const FeatureFrame& second,
                                                                  float radius_px, const MatchLimits& limits) {
  std::vector<ExpectedFeature> expected;
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    const int level = first.level(i);
    if (!first.pixel(i).allFinite()) continue;
    expected.push_back({i, first.pixel(i).x(), first.pixel(i).y(), radius_px, std::nanf(""),
                        static_cast<std::uint8_t>(std::max(0, level - 1)), static_cast<std::uint8_t>(level + 1),
                        &first.descriptor(i)});
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const FeatureMatch& match : match_expected(second, expected, limits))
    pairs.emplace_back(match.subject, match.feature);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace rastro
