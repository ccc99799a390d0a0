// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/keyframe_features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rastro/backend/rgbd/keyframe_matcher.h"

namespace rastro {
namespace {

constexpr int cells_across = 8, cells_down = 6;
constexpr int spare = 2;  ///< Detects this many times the features asked for, to choose from when spreading them.

DescriptorExtractorOptions extractor_options(const RgbdSlamOptions& options) {
  DescriptorExtractorOptions extractor;
  extractor.max_keypoints = spare * options.keyframe_features;
  return extractor;
}

bool masked(const Frame& frame, const Keypoint& keypoint) {
  const int x = static_cast<int>(std::lround(keypoint.x)), y = static_cast<int>(std::lround(keypoint.y));
  if (frame.mask.empty() || x < 0 || y < 0 || x >= frame.mask.width() || y >= frame.mask.height()) return false;
  return frame.mask.at(x, y) == 0;
}

void append(const Features& from, std::size_t i, Features& to) {
  to.keypoints.push_back(from.keypoints[i]);
  const auto length = static_cast<std::ptrdiff_t>(from.length);
  const auto begin = from.floats.begin() + static_cast<std::ptrdiff_t>(i) * length;
  if (length > 0) to.floats.insert(to.floats.end(), begin, begin + length);
  if (length == 0) to.descriptors.push_back(from.descriptors[i]);
}

/// The strongest of each cell of the image first, then the second of each, until there are enough.
Features spread(const Features& all, const Frame& frame, std::size_t most) {
  std::array<std::vector<std::size_t>, cells_across * cells_down> cells;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Keypoint& keypoint = all.keypoints[i];
    if (masked(frame, keypoint)) continue;
    const auto cell = [](float position, int size, int cells_along) {
      return std::clamp(static_cast<int>(position) * cells_along / std::max(1, size), 0, cells_along - 1);
    };
    const int row = cell(keypoint.y, frame.image.height(), cells_down);
    cells[static_cast<std::size_t>(row * cells_across + cell(keypoint.x, frame.image.width(), cells_across))].push_back(
        i);
  }
  std::vector<std::size_t> chosen;
  for (std::size_t rank = 0, left = 1; chosen.size() < most && left > 0; ++rank) {
    left = 0;
    for (const auto& cell : cells) {
      if (rank >= cell.size() || chosen.size() >= most) continue;
      chosen.push_back(cell[rank]);
      ++left;
    }
  }
  std::sort(chosen.begin(), chosen.end());
  Features result;
  result.length = all.length;
  for (const std::size_t i : chosen) append(all, i, result);
  return result;
}

}  // namespace

float feature_depth(const DepthImage& depth, float x, float y, const DepthNoise& noise) {
  constexpr int reach = 2;
  constexpr double jump_share = 0.04, jump_sigmas = 3.0;
  const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
  if (cx < reach || cy < reach || cx >= depth.width() - reach || cy >= depth.height() - reach) return 0.0F;
  std::array<float, (2 * reach + 1) * (2 * reach + 1)> found{};
  std::size_t count = 0;
  for (int j = cy - reach; j <= cy + reach; ++j) {
    for (int i = cx - reach; i <= cx + reach; ++i) {
      const float meters = depth.at(i, j);
      if (meters > 0.0F && std::isfinite(meters)) found[count++] = meters;
    }
  }
  if (2 * count < found.size()) return 0.0F;
  const auto begin = found.begin(), end = begin + static_cast<std::ptrdiff_t>(count),
             middle = begin + (end - begin) / 2;
  const auto [nearest, farthest] = std::minmax_element(begin, end);
  const auto from_m = static_cast<double>(*nearest), to_m = static_cast<double>(*farthest);
  if (to_m - from_m > std::max(jump_share * from_m, jump_sigmas * noise.sigma(from_m))) return 0.0F;
  std::nth_element(begin, middle, end);
  return *middle;
}

KeyframeFeatures::KeyframeFeatures(const RgbdSlamOptions& options) : options_(options) {
  if (options.descriptor == "even_orb") {
    orb_ = std::make_unique<OrbExtractor>(OrbOptions{.features = options.keyframe_features});
  } else {
    extractor_ = DescriptorExtractor::create(descriptor_kind(options.descriptor, "option descriptor"),
                                             extractor_options(options));
  }
}

Features KeyframeFeatures::detect(const Frame& frame, std::size_t most) {
  if (!orb_) return spread(extractor_->extract(frame.image.view()), frame, most);
  Features features = orb_->extract(frame.image.view(), frame.mask.view());
  features.levels.clear();
  return features.size() <= most ? features : spread(features, frame, most);
}

ImageFeatures KeyframeFeatures::extract(const Frame& frame, double share) {
  ImageFeatures keyframe;
  keyframe.frame = frame.index;
  keyframe.stamp = frame.stamp;
  const auto most = static_cast<std::size_t>(std::lround(share * options_.keyframe_features));
  keyframe.features = detect(frame, most);
  const auto least = static_cast<float>(options_.follow.min_depth_m),
             farthest = static_cast<float>(options_.follow.max_depth_m);
  for (const Keypoint& keypoint : keyframe.features.keypoints) {
    const float meters = feature_depth(frame.depth, keypoint.x, keypoint.y, depth_noise(options_));
    keyframe.depths.push_back(meters >= least && meters <= farthest ? meters : 0.0F);
  }
  return keyframe;
}

}  // namespace rastro
