// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/static_stereo.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rastro/slam/lsd/tracking/alignment_reference.h"

namespace rastro {
namespace {

/// Room for the places beside the interval and those that a search adds.
constexpr double most_coarse_px = most_line_steps - 6;

int level_for(const StaticStereoOptions& options, int levels) {
  int level = 0;
  while (level + 1 < levels && std::ldexp(options.max_disparity_px, -level) > most_coarse_px) ++level;
  return level;
}

Camera level_camera(const Camera& camera, int level) {
  const LevelCamera scaled(camera, level);
  Camera result = camera;
  result.fx = scaled.fx, result.fy = scaled.fy, result.cx = scaled.cx, result.cy = scaled.cy;
  return result;
}

EpipolarSearchOptions search_options(const StaticStereoOptions& options, bool coarse) {
  EpipolarSearchOptions search = options.search;
  search.min_line_px = coarse ? 0.0 : options.min_disparity_px;
  search.max_length_px = 2.0 * most_coarse_px;
  return search;
}

bool is_matched(const EpipolarMatches& matches, std::size_t i) {
  return matches.result[i] == static_cast<int>(EpipolarResult::matched);
}

}  // namespace

StaticStereo::StaticStereo(const Pyramid& left, const Pyramid& right, const Camera& camera, double gain, double offset,
                           const StaticStereoOptions& options)
    : options_(options),
      focal_times_baseline_(camera.fx * options.baseline),
      level_(level_for(options, std::min(left.levels(), right.levels()))),
      coarse_(std::ldexp(1.0, level_)),
      fine_(left.level(0).view(), right.level(0).view(), camera, SE3(SO3(), {-options.baseline, 0.0, 0.0}), gain,
            offset, search_options(options, false)),
      coarse_search_(left.level(level_).view(), right.level(level_).view(), level_camera(camera, level_),
                     SE3(SO3(), {-options.baseline, 0.0, 0.0}), gain, offset, search_options(options, true)),
      coarse_check_(right.level(level_).view(), left.level(level_).view(), level_camera(camera, level_),
                    SE3(SO3(), {options.baseline, 0.0, 0.0}), 1.0 / gain, -offset / gain,
                    search_options(options, true)) {}

DepthPrior StaticStereo::any_depth() const {
  const double most = std::min(options_.max_disparity_px, most_coarse_px * coarse_) / focal_times_baseline_;
  return {0.0, 0.5 * most, most};
}

EpipolarMatch StaticStereo::find(int x, int y, const DepthPrior& prior) const { return find_one(*this, x, y, prior); }

void StaticStereo::find(const EpipolarQueries& queries, EpipolarMatches& matches) const {
  if (queries.known) return fine_.find(queries, matches);
  find_anywhere(queries, matches);
  EpipolarQueries refined;
  refined.known = true;
  std::array<std::size_t, epipolar_batch> index_of;
  const double reach = coarse_ / focal_times_baseline_;
  for (std::size_t i = 0; i < static_cast<std::size_t>(queries.count); ++i) {
    if (!is_matched(matches, i)) continue;
    const auto expected = static_cast<double>(matches.mean[i]);
    index_of[static_cast<std::size_t>(refined.count)] = i;
    add_query(static_cast<int>(queries.x[i]), static_cast<int>(queries.y[i]),
              {std::max(0.0, expected - reach), expected, expected + reach, true}, refined);
  }
  EpipolarMatches fine;
  fine_.find(refined, fine);
  for (std::size_t k = 0; k < static_cast<std::size_t>(refined.count); ++k) {
    const std::size_t i = index_of[k];
    matches.result[i] = fine.result[k], matches.mean[i] = fine.mean[k], matches.variance[i] = fine.variance[k];
  }
}

/// Whole pixels of the coarse level.
void StaticStereo::find_anywhere(const EpipolarQueries& queries, EpipolarMatches& matches) const {
  EpipolarQueries coarse;
  for (std::size_t i = 0; i < static_cast<std::size_t>(queries.count); ++i)
    add_query(static_cast<int>(std::lround(static_cast<double>(queries.x[i]) / coarse_)),
              static_cast<int>(std::lround(static_cast<double>(queries.y[i]) / coarse_)), any_depth(), coarse);
  coarse_search_.find(coarse, matches);
  check_backward(coarse, matches);
}

/// What the search from the right image does not confirm gets its result.
void StaticStereo::check_backward(const EpipolarQueries& coarse, EpipolarMatches& found) const {
  EpipolarQueries back;
  EpipolarMatches there;
  std::array<std::size_t, epipolar_batch> index_of;
  const double disparity_of = focal_times_baseline_ / coarse_;
  for (std::size_t i = 0; i < static_cast<std::size_t>(coarse.count); ++i) {
    if (!is_matched(found, i)) continue;
    const double disparity = static_cast<double>(found.mean[i]) * disparity_of;
    const int right_x = static_cast<int>(std::lround(static_cast<double>(coarse.x[i]) - disparity));
    if (right_x < 1) {
      found.result[i] = static_cast<int>(EpipolarResult::outside);
      continue;
    }
    index_of[static_cast<std::size_t>(back.count)] = i;
    add_query(right_x, static_cast<int>(coarse.y[i]), any_depth(), back);
  }
  coarse_check_.find(back, there);
  for (std::size_t k = 0; k < static_cast<std::size_t>(back.count); ++k) {
    std::int32_t& result = found.result[index_of[k]];
    const auto difference = static_cast<double>(there.mean[k] - found.mean[index_of[k]]) * disparity_of;
    if (!is_matched(there, k))
      result = there.result[k];
    else if (std::abs(difference) > options_.max_check_px)  // the pixel is rounded to a whole one
      result = static_cast<int>(EpipolarResult::ambiguous);
  }
}

}  // namespace rastro
