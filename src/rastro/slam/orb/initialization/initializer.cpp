// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/initialization/initializer.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/backend/guided_search.h"

namespace rastro {

void Initializer::clear() {
  frames_.clear();
  first_ = 0;
  detail_.clear();
}

void Initializer::keep(std::shared_ptr<const FeatureFrame> frame) {
  frames_.push_back(std::move(frame));
  if (frames_.size() > static_cast<std::size_t>(options_.init_frames)) {
    frames_.pop_front();
    first_ -= first_ > 0 ? 1 : 0;
  }
}

std::optional<InitialPair> Initializer::add(std::shared_ptr<const FeatureFrame> frame) {
  keep(std::move(frame));
  const std::size_t second = frames_.size() - 1;
  if (second == 0) detail_ = "the first frame";
  // A first frame that no longer matches the newest one is replaced by a later one.
  while (first_ < second) {
    Attempt attempt = try_pair(first_, second);
    detail_ = attempt.detail;
    if (attempt.start) return attempt.start;
    if (attempt.status == TwoViewStatus::no_model) return nearer_pair(second);
    if (attempt.status != TwoViewStatus::too_few_pairs) break;
    ++first_;
  }
  return std::nullopt;
}

/// With two frames far apart, many matches may be wrong. The first frame is replaced by one nearer to the second that
/// shares a motion with it. If there is none, the newest frame is the problem.
std::optional<InitialPair> Initializer::nearer_pair(std::size_t second) {
  for (std::size_t gap = (second - first_) / 2; gap > 0; gap /= 2) {
    Attempt attempt = try_pair(second - gap, second);
    if (attempt.status == TwoViewStatus::no_model || attempt.status == TwoViewStatus::too_few_pairs) continue;
    first_ = second - gap;
    detail_ = attempt.detail;
    return attempt.start;
  }
  return std::nullopt;
}

Initializer::Attempt Initializer::try_pair(std::size_t first, std::size_t second) const {
  const FeatureFrame &a = *frames_[first], &b = *frames_[second];
  const auto radius = static_cast<float>(options_.init_window_share * camera_.width);
  InitialPair start{first, second, {}, {}, {}};
  start.pairs = match_within_radius(a.grid(), b.grid(), radius,
                                    {.max_distance = options_.init_hamming, .max_ratio = options_.init_ratio});
  if (start.pairs.size() < static_cast<std::size_t>(options_.init_matches))
    return {TwoViewStatus::too_few_pairs,
            fmt::format("needs at least {} matches, got {}", options_.init_matches, start.pairs.size()), std::nullopt};
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
  if (fit.status != TwoViewStatus::found) return {fit.status, fit.detail, std::nullopt};
  start.second_from_first = fit.second_from_first;
  start.points = std::move(fit.points);
  return {fit.status, fit.detail, std::move(start)};
}

}  // namespace rastro
