// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/stereo_matching.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include "rastro/feature/hamming.h"

namespace rastro {
namespace {

constexpr int half_window = 5;
constexpr int reach = 5;  ///< Steps to either side of the feature in the right picture.

/// Right features by row.
std::vector<std::vector<std::uint32_t>> by_row(const OrbFeatures& features, int rows,
                                               const std::vector<double>& scales) {
  std::vector<std::vector<std::uint32_t>> result(static_cast<std::size_t>(std::max(0, rows)));
  for (std::uint32_t i = 0; i < features.size(); ++i) {
    const double y = static_cast<double>(features.keypoints[i].y), band = 2.0 * scales[features.levels[i]];
    const int first = std::max(0, static_cast<int>(std::ceil(y - band)));
    const int last = std::min(rows - 1, static_cast<int>(std::floor(y + band)));
    for (int row = first; row <= last; ++row) result[static_cast<std::size_t>(row)].push_back(i);
  }
  return result;
}

/// Mean squared difference of grey levels, each less its window's centre; pixels `step` apart. Squares are smooth at
/// their least, so that a parabola finds it; absolute differences have a kink there.
double difference(GreyView left, int lx, GreyView right, int rx, int y, int step) {
  const int shift = left.at(lx, y) - right.at(rx, y);
  int sum = 0;
  for (int dy = -half_window; dy <= half_window; ++dy) {
    const std::uint8_t* a = left.row(y + dy * step) + lx;
    const std::uint8_t* b = right.row(y + dy * step) + rx;
    for (int dx = -half_window * step; dx <= half_window * step; dx += step) {
      const int d = a[dx] - b[dx] - shift;
      sum += d * d;
    }
  }
  return static_cast<double>(sum) / ((2 * half_window + 1) * (2 * half_window + 1));
}

struct Shift {
  double disparity = 0.0, difference = 0.0;
};

std::optional<Shift> refine(GreyView left, GreyView right, const Keypoint& keypoint, double right_x, int step) {
  const int lx = static_cast<int>(std::lround(keypoint.x)), y = static_cast<int>(std::lround(keypoint.y));
  const int start = static_cast<int>(std::lround(right_x)), border = half_window * step;
  if (y < border || y >= left.height - border || lx < border || lx >= left.width - border) return std::nullopt;
  if (start - border - reach * step < 0 || start + border + reach * step >= right.width) return std::nullopt;
  std::vector<double> differences(static_cast<std::size_t>(2 * reach * step) + 1);
  for (std::size_t i = 0; i < differences.size(); ++i)
    differences[i] = difference(left, lx, right, start - reach * step + static_cast<int>(i), y, step);
  const auto best =
      static_cast<std::size_t>(std::min_element(differences.begin(), differences.end()) - differences.begin());
  if (best == 0 || best + 1 == differences.size()) return std::nullopt;
  const double before = differences[best - 1], at = differences[best], after = differences[best + 1];
  const double bend = before - 2.0 * at + after;
  const double part = bend > 0.0 ? 0.5 * (before - after) / bend : 0.0;
  return Shift{lx - (start - reach * step + static_cast<double>(best) + part), std::sqrt(at)};
}

}  // namespace

void match_stereo(GreyView left, GreyView right, const OrbFeatures& right_features, double focal_baseline,
                  const OrbSlamOptions& options, LandmarkKeyframe& keyframe) {
  const OrbFeatures& features = keyframe.features;
  keyframe.right_x.assign(features.size(), -1.0F);
  keyframe.depths.assign(features.size(), 0.0F);
  if (right.width != left.width || right.height != left.height) return;
  const std::vector<double> scales = orb_level_scales({.levels = options.levels, .scale_factor = options.scale_factor});
  const auto rows = by_row(right_features, right.height, scales);
  std::vector<double> differences(features.size(), std::numeric_limits<double>::infinity()), known;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Keypoint& keypoint = features.keypoints[i];
    const auto row =
        static_cast<std::size_t>(std::clamp(static_cast<int>(std::lround(keypoint.y)), 0, left.height - 1));
    int best = options.stereo_hamming + 1;
    std::int64_t match = -1;
    for (const std::uint32_t k : rows[row]) {
      const double disparity = static_cast<double>(keypoint.x - right_features.keypoints[k].x);
      if (disparity < -2.0 || disparity > options.stereo_disparity_share * left.width) continue;
      if (std::abs(static_cast<int>(right_features.levels[k]) - static_cast<int>(features.levels[i])) > 1) continue;
      const int distance = hamming_distance(features.descriptors[i], right_features.descriptors[k]);
      if (distance >= best) continue;
      best = distance;
      match = k;
    }
    if (match < 0) continue;
    const int step = std::max(1, static_cast<int>(std::lround(scales[features.levels[i]])));
    const auto shift = refine(left, right, keypoint,
                              static_cast<double>(right_features.keypoints[static_cast<std::size_t>(match)].x), step);
    if (!shift || shift->disparity < options.stereo_least_disparity_px) continue;
    keyframe.right_x[i] = static_cast<float>(static_cast<double>(keypoint.x) - shift->disparity);
    keyframe.depths[i] = static_cast<float>(focal_baseline / shift->disparity);
    differences[i] = shift->difference;
    known.push_back(shift->difference);
  }
  if (known.empty()) return;
  // Windows that differ much more than most show different things.
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (differences[i] <= options.stereo_difference_ratio * *middle) continue;
    keyframe.right_x[i] = -1.0F;
    keyframe.depths[i] = 0.0F;
  }
}

}  // namespace rastro
