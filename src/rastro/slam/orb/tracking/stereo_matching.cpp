// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/stereo_matching.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include "rastro/feature/hamming.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr int half_window = 5;
constexpr int side = 2 * half_window + 1;
constexpr int reach = 5;  ///< Shifts to either side of the feature in the right image.
constexpr int lanes = 16;
constexpr int grain = 32;  ///< Features per task.

/// Right features by row, contiguous per row.
class Rows {
 public:
  Rows(const Features& features, int rows, const std::vector<double>& scales)
      : first_(static_cast<std::size_t>(std::max(0, rows)) + 1, 0) {
    const auto each = [&](const auto& visit) {
      for (std::uint32_t i = 0; i < features.size(); ++i) {
        const double y = static_cast<double>(features.keypoints[i].y), band = 2.0 * scales[features.levels[i]];
        const int begin = std::max(0, static_cast<int>(std::ceil(y - band)));
        const int end = std::min(rows - 1, static_cast<int>(std::floor(y + band)));
        for (int row = begin; row <= end; ++row) visit(static_cast<std::size_t>(row), i);
      }
    };
    each([&](std::size_t row, std::uint32_t) { ++first_[row + 1]; });
    for (std::size_t row = 1; row < first_.size(); ++row) first_[row] += first_[row - 1];
    indices_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    each([&](std::size_t row, std::uint32_t i) { indices_[next[row]++] = i; });
  }

  std::span<const std::uint32_t> at(std::size_t row) const {
    return {indices_.data() + first_[row], first_[row + 1] - first_[row]};
  }

 private:
  std::vector<std::uint32_t> first_, indices_;
};

/// Intensities around a feature, minus the one in the center; rows are padded with zeros to whole vectors.
struct Window {
  alignas(32) std::int16_t values[side][lanes] = {};
  int sum = 0, squares = 0;

  Window(GrayView image, int x, int y, int step) {
    const int middle = image.at(x, y);
    for (int row = 0; row < side; ++row) {
      const std::uint8_t* from = image.row(y + (row - half_window) * step) + x - half_window * step;
      for (int column = 0; column < side; ++column) {
        const int value = from[column * step] - middle;
        values[row][column] = static_cast<std::int16_t>(value);
        sum += value;
        squares += value * value;
      }
    }
  }
};

/// Every `step`-th intensity of the rows around a position: side by side, the windows of all positions `step` apart.
struct Strip {
  static constexpr int length = 2 * reach + side, room = 2 * reach + lanes;
  alignas(32) std::int16_t values[side][room] = {};
  int sums[length] = {}, squares[length] = {};  ///< Of each column.

  void read(GrayView image, int x, int y, int step) {
    std::fill_n(sums, length, 0);
    std::fill_n(squares, length, 0);
    for (int row = 0; row < side; ++row) {
      const std::uint8_t* from = image.row(y + (row - half_window) * step);
      for (int column = 0; column < length; ++column) {
        const int at = x + column * step, value = at < image.width ? from[at] : 0;
        values[row][column] = static_cast<std::int16_t>(value);
        sums[column] += value;
        squares[column] += value * value;
      }
    }
  }
};

/// Sum of squared differences between a window and the one `shift` columns into a strip, each minus its center's
/// intensity. It is multiplied out, so that only the products must be summed again for each shift.
int squared_difference(const Window& window, const Strip& strip, int shift) {
  int product = 0, sum = 0, squares = 0;
  for (int row = 0; row < side; ++row) {
    const std::int16_t *a = window.values[row], *b = strip.values[row] + shift;
    int of_row = 0;
    for (int k = 0; k < lanes; ++k) of_row += a[k] * b[k];
    product += of_row;
  }
  for (int column = shift; column < shift + side; ++column) {
    sum += strip.sums[column];
    squares += strip.squares[column];
  }
  const int middle = strip.values[half_window][shift + half_window];
  return window.squares + squares - 2 * product + 2 * middle * (window.sum - sum) + side * side * middle * middle;
}

struct Shift {
  double disparity = 0.0, difference = 0.0;
};

/// Finds the shift with the smallest intensity difference. Squares are smooth at their minimum, so that a parabola
/// finds it; absolute differences have a kink there.
std::optional<Shift> refine(GrayView left, GrayView right, const Keypoint& keypoint, double right_x, int step) {
  const int lx = static_cast<int>(std::lround(keypoint.x)), y = static_cast<int>(std::lround(keypoint.y));
  const int start = static_cast<int>(std::lround(right_x)), border = half_window * step;
  if (y < border || y >= left.height - border || lx < border || lx >= left.width - border) return std::nullopt;
  if (start - border - reach * step < 0 || start + border + reach * step >= right.width) return std::nullopt;
  const Window window(left, lx, y, step);
  const int first = start - reach * step, count = 2 * reach * step + 1;
  std::vector<int> sums(static_cast<std::size_t>(count));
  Strip strip;
  for (int offset = 0; offset < std::min(step, count); ++offset) {
    strip.read(right, first - border + offset, y, step);
    for (int at = offset; at < count; at += step)
      sums[static_cast<std::size_t>(at)] = squared_difference(window, strip, at / step);
  }
  const auto best = static_cast<std::size_t>(std::min_element(sums.begin(), sums.end()) - sums.begin());
  if (best == 0 || best + 1 == sums.size()) return std::nullopt;
  const double before = sums[best - 1], at = sums[best], after = sums[best + 1];
  const double bend = before - 2.0 * at + after;
  const double part = bend > 0.0 ? 0.5 * (before - after) / bend : 0.0;
  return Shift{lx - (first + static_cast<double>(best) + part), std::sqrt(at / (side * side))};
}

/// Processes the features of the left image one by one.
class StereoMatcher {
 public:
  StereoMatcher(GrayView left, GrayView right, const Features& left_features, const Features& right_features,
                const OrbSlamOptions& options)
      : left_(left),
        right_(right),
        features_(left_features),
        right_features_(right_features),
        options_(options),
        scales_(orb_level_scales({.levels = options.levels, .scale_factor = options.scale_factor})),
        rows_(right_features, right.height, scales_) {}

  std::optional<Shift> match(std::size_t i) const {
    const std::int64_t similar = most_similar(i);
    if (similar < 0) return std::nullopt;
    const int step = std::max(1, static_cast<int>(std::lround(scales_[features_.levels[i]])));
    const double start = static_cast<double>(right_features_.keypoints[static_cast<std::size_t>(similar)].x);
    const auto shift = refine(left_, right_, features_.keypoints[i], start, step);
    return shift && shift->disparity >= options_.stereo_least_disparity_px ? shift : std::nullopt;
  }

 private:
  /// Among the right image's features near the same row and with about the same size; -1: none is similar enough.
  std::int64_t most_similar(std::size_t i) const {
    const Keypoint& keypoint = features_.keypoints[i];
    const auto row =
        static_cast<std::size_t>(std::clamp(static_cast<int>(std::lround(keypoint.y)), 0, left_.height - 1));
    const double most = options_.stereo_disparity_share * left_.width;
    thread_local std::vector<std::uint32_t> candidates;
    thread_local std::vector<Descriptor> descriptors;
    thread_local std::vector<std::uint16_t> distances;
    candidates.clear();
    descriptors.clear();
    for (const std::uint32_t k : rows_.at(row)) {
      const double disparity = static_cast<double>(keypoint.x - right_features_.keypoints[k].x);
      if (disparity < -2.0 || disparity > most) continue;
      if (std::abs(static_cast<int>(right_features_.levels[k]) - static_cast<int>(features_.levels[i])) > 1) continue;
      candidates.push_back(k);
      descriptors.push_back(right_features_.descriptors[k]);
    }
    distances.resize(candidates.size());
    hamming_distances(features_.descriptors[i], descriptors, distances);
    const auto best = std::min_element(distances.begin(), distances.end());
    if (best == distances.end() || static_cast<int>(*best) > options_.stereo_hamming) return -1;
    return candidates[static_cast<std::size_t>(best - distances.begin())];
  }

  GrayView left_, right_;
  const Features &features_, &right_features_;
  const OrbSlamOptions& options_;
  std::vector<double> scales_;
  Rows rows_;
};

/// Windows that differ much more than most show different surfaces.
double most_difference(const std::vector<std::optional<Shift>>& shifts, double ratio) {
  std::vector<double> known;
  for (const auto& shift : shifts) {
    if (shift) known.push_back(shift->difference);
  }
  return ratio * upper_median_or(std::move(known), 0.0);
}

}  // namespace

void match_stereo(GrayView left, GrayView right, const Features& right_features, double focal_baseline,
                  const OrbSlamOptions& options, TaskPool* pool, ImageFeatures& keyframe) {
  const Features& features = keyframe.features;
  keyframe.right_x.assign(features.size(), -1.0F);
  keyframe.depths.assign(features.size(), 0.0F);
  if (right.width != left.width || right.height != left.height) return;
  const StereoMatcher matcher(left, right, features, right_features, options);
  std::vector<std::optional<Shift>> shifts(features.size());
  const auto match = [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) shifts[i] = matcher.match(i);
  };
  const auto count = static_cast<int>(features.size());
  if (pool) {
    pool->for_chunks(0, count, grain, match);
  } else {
    match(0, count);
  }
  const double most = most_difference(shifts, options.stereo_difference_ratio);
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!shifts[i] || shifts[i]->difference > most) continue;
    const double disparity = shifts[i]->disparity;
    keyframe.right_x[i] = static_cast<float>(static_cast<double>(features.keypoints[i].x) - disparity);
    keyframe.depths[i] = static_cast<float>(focal_baseline / disparity);
  }
}

}  // namespace rastro
