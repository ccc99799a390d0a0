// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/initialiser.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/slam/orb/matching.h"

namespace rastro {

void Initialiser::clear() {
  frames_.clear();
  first_ = 0;
  detail_.clear();
}

std::optional<StartPair> Initialiser::add(std::shared_ptr<const FeatureFrame> frame) {
  frames_.push_back(std::move(frame));
  if (frames_.size() > static_cast<std::size_t>(options_.init_frames)) {
    frames_.pop_front();
    first_ -= first_ > 0 ? 1 : 0;
  }
  const std::size_t second = frames_.size() - 1;
  if (second == 0) detail_ = "the first frame";
  // What no longer looks like the newest frame gives way to what came after it.
  while (first_ < second) {
    const std::size_t tried = first_;
    if (auto start = try_pair(first_, second)) return start;
    if (first_ == tried) break;
  }
  return std::nullopt;
}

std::optional<StartPair> Initialiser::try_pair(std::size_t first, std::size_t second) {
  const FeatureFrame &a = *frames_[first], &b = *frames_[second];
  const auto radius = static_cast<float>(options_.init_window_share * camera_.width);
  StartPair start{first, second, {}, {}, {}};
  start.pairs = match_within(a, b, radius, {.max_distance = options_.init_hamming, .max_ratio = options_.init_ratio});
  if (start.pairs.size() < static_cast<std::size_t>(options_.init_matches)) {
    detail_ = fmt::format("{} matches, need {}", start.pairs.size(), options_.init_matches);
    ++first_;
    return std::nullopt;
  }
  const std::vector<double> scales =
      orb_level_scales({.levels = options_.levels, .scale_factor = options_.scale_factor});
  std::vector<TwoViewPair> pairs;
  for (const auto& [i, k] : start.pairs)
    pairs.push_back(
        {a.ray(i), b.ray(k), options_.pixel_sigma * scales[a.level(i)], options_.pixel_sigma * scales[b.level(k)]});
  TwoViewOptions options;
  options.focal_px = camera_.fx;
  options.homography_share = options_.init_homography_share;
  options.min_points = options_.init_points;
  options.min_parallax_deg = options_.init_parallax_deg;
  options.max_iterations = options_.init_iterations;
  options.seed = options_.seed;
  TwoViewFit fit = find_two_view_motion(pairs, options);
  detail_ = fit.detail;
  if (fit.status != TwoViewStatus::found) return std::nullopt;
  start.second_from_first = fit.second_from_first;
  start.points = std::move(fit.points);
  return start;
}

}  // namespace rastro
