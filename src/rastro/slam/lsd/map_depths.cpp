// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/map_depths.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "rastro/slam/lsd/depth/surface_spread.h"

namespace rastro {
namespace {

/// The `most` pixels whose depths are the most certain ones, relative to themselves; row by row as before.
void keep_most_certain(std::vector<SemiDenseDepth::Pixel>& pixels, std::size_t most) {
  if (pixels.size() <= most) return;
  std::vector<std::pair<float, std::size_t>> by_error;
  by_error.reserve(pixels.size());
  for (const SemiDenseDepth::Pixel& pixel : pixels)
    by_error.emplace_back(pixel.variance / (pixel.inverse_depth * pixel.inverse_depth), by_error.size());
  std::nth_element(by_error.begin(), by_error.begin() + static_cast<std::ptrdiff_t>(most), by_error.end());
  by_error.resize(most);
  std::sort(by_error.begin(), by_error.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  std::vector<SemiDenseDepth::Pixel> kept;
  kept.reserve(most);
  for (const auto& [error, index] : by_error) kept.push_back(pixels[index]);
  pixels = std::move(kept);
}

std::size_t most_in_map(const SemiDenseKeyframe& keyframe, const LsdOptions& options) {
  const double size = static_cast<double>(keyframe.depth.width()) * keyframe.depth.height();
  return static_cast<std::size_t>(options.map_share * size);
}

}  // namespace

std::shared_ptr<const SemiDenseDepth> depths_in_map(const SemiDenseKeyframe& keyframe, const KeyframeScale& scale,
                                                    const LsdOptions& options) {
  auto result = std::make_shared<SemiDenseDepth>();
  const auto factor = static_cast<float>(1.0 / scale.world_per_unit);
  const double most = options.max_depth_sigma > 0.0 ? options.max_depth_sigma : std::numeric_limits<double>::infinity();
  const auto surface_share = static_cast<float>(options.surface_share);
  for (int y = 0; y < keyframe.depth.height(); ++y)
    for (int x = 0; x < keyframe.depth.width(); ++x) {
      const float mean = factor * keyframe.depth.mean.at(x, y), own_variance = keyframe.depth.variance.at(x, y);
      if (!keyframe.depth.is_known(x, y) || !(mean > 0.0F)) continue;
      if (factor * std::sqrt(own_variance) > most * mean) continue;
      const float variance = own_variance + surface_share * surface_spread(keyframe.depth, x, y);
      result->pixels.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), mean,
                                factor * factor * variance, keyframe.image.at(x, y)});
    }
  keep_most_certain(result->pixels, most_in_map(keyframe, options));
  const auto of_scale = static_cast<float>(scale.variance);
  for (SemiDenseDepth::Pixel& pixel : result->pixels)
    pixel.variance += of_scale * pixel.inverse_depth * pixel.inverse_depth;
  return result;
}

std::size_t bytes_in_map(const SemiDenseKeyframe& keyframe, const LsdOptions& options) {
  std::size_t known = 0;
  for (int y = 0; y < keyframe.depth.height(); ++y)
    for (int x = 0; x < keyframe.depth.width(); ++x) known += keyframe.depth.is_known(x, y) ? 1 : 0;
  return std::min(known, most_in_map(keyframe, options)) * sizeof(SemiDenseDepth::Pixel);
}

std::shared_ptr<const SemiDenseDepth> KnownMapDepths::of(const std::shared_ptr<const SemiDenseKeyframe>& keyframe,
                                                         const KeyframeScale& scale, const LsdOptions& options) {
  constexpr double same_scale = 1e-3;
  const auto index = static_cast<std::size_t>(keyframe->id);
  if (index >= known_.size()) known_.resize(index + 1);
  Known& known = known_[index];
  const bool is_same = known.keyframe.lock() == keyframe &&
                       std::abs(scale.world_per_unit / known.scale.world_per_unit - 1.0) < same_scale &&
                       std::abs(std::sqrt(scale.variance) - std::sqrt(known.scale.variance)) < same_scale;
  if (is_same)
    if (auto depths = known.depths.lock()) return depths;
  auto depths = depths_in_map(*keyframe, scale, options);
  known = {keyframe, depths, scale};
  return depths;
}

}  // namespace rastro
