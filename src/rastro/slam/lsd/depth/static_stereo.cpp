// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/static_stereo.h"

#include <algorithm>
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

EpipolarMatch StaticStereo::find(int x, int y, const DepthPrior& prior) const {
  if (prior.is_known) return fine_.find(x, y, prior);
  const EpipolarMatch anywhere = find_anywhere(x, y);
  if (anywhere.result != EpipolarResult::matched) return anywhere;
  const auto expected = static_cast<double>(anywhere.mean);
  const double reach = coarse_ / focal_times_baseline_;
  return fine_.find(x, y, {std::max(0.0, expected - reach), expected, expected + reach, true});
}

EpipolarMatch StaticStereo::find_anywhere(int x, int y) const {
  const int left_x = static_cast<int>(std::lround(x / coarse_)), row = static_cast<int>(std::lround(y / coarse_));
  const EpipolarMatch found = coarse_search_.find(left_x, row, any_depth());
  if (found.result != EpipolarResult::matched) return found;
  const double disparity = static_cast<double>(found.mean) * focal_times_baseline_ / coarse_;
  const int right_x = static_cast<int>(std::lround(left_x - disparity));
  if (right_x < 1) return {EpipolarResult::outside};
  const EpipolarMatch back = coarse_check_.find(right_x, row, any_depth());
  if (back.result != EpipolarResult::matched) return back;
  const double there = static_cast<double>(back.mean) * focal_times_baseline_ / coarse_;
  // The pixel is rounded to a whole one.
  if (std::abs(there - disparity) > options_.max_check_px) return {EpipolarResult::ambiguous};
  return found;
}

}  // namespace rastro
