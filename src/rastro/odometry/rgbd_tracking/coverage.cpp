// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/coverage.h"

#include <algorithm>

namespace rastro {
namespace {

constexpr int columns = 8, rows = 6;
// A part of the image with few observations counts less: they may be wrong.
constexpr int few = 2;
constexpr int most_weight = 1000;

std::size_t cell_of(const FoundPoint& point, const Camera& camera) {
  const auto at = [](float pixel, int size, int cells) {
    return std::clamp(static_cast<int>(pixel * static_cast<float>(cells) / static_cast<float>(std::max(1, size))), 0,
                      cells - 1);
  };
  return static_cast<std::size_t>(at(point.pixel.y(), camera.height, rows) * columns +
                                  at(point.pixel.x(), camera.width, columns));
}

}  // namespace

std::vector<std::int32_t> coverage_weights(std::span<const FoundPoint> found, const Camera& camera) {
  std::vector<int> count(static_cast<std::size_t>(columns) * rows, few);
  for (const FoundPoint& point : found) ++count[cell_of(point, camera)];
  std::vector<std::int32_t> weights;
  weights.reserve(found.size());
  for (const FoundPoint& point : found) weights.push_back(std::max(1, most_weight / count[cell_of(point, camera)]));
  return weights;
}

double weighted_share(std::span<const std::int32_t> weights, std::span<const std::uint8_t> chosen) {
  std::int64_t all = 0, sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    all += weights[i];
    if (chosen[i] != 0) sum += weights[i];
  }
  return all > 0 ? static_cast<double>(sum) / static_cast<double>(all) : 0.0;
}

ImageParts moving_parts(std::span<const FoundPoint> found, std::span<const std::uint8_t> fits, const Camera& camera) {
  constexpr int least = 2;
  ImageParts parts;
  parts.columns = (camera.width + ImageParts::part_px - 1) / ImageParts::part_px;
  parts.rows = (camera.height + ImageParts::part_px - 1) / ImageParts::part_px;
  const auto size = static_cast<std::size_t>(parts.columns * parts.rows);
  parts.chosen.assign(size, 0);
  std::vector<int> fitting(size, 0), other(size, 0);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const int x = std::clamp(static_cast<int>(found[i].pixel.x()) / ImageParts::part_px, 0, parts.columns - 1);
    const int y = std::clamp(static_cast<int>(found[i].pixel.y()) / ImageParts::part_px, 0, parts.rows - 1);
    ++(fits[i] != 0 ? fitting : other)[static_cast<std::size_t>(y * parts.columns + x)];
  }
  for (int y = 0; y < parts.rows; ++y) {
    for (int x = 0; x < parts.columns; ++x) {
      const auto at = static_cast<std::size_t>(y * parts.columns + x);
      if (other[at] < least || other[at] <= fitting[at]) continue;
      for (int v = std::max(0, y - 1); v <= std::min(parts.rows - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(parts.columns - 1, x + 1); ++u)
          parts.chosen[static_cast<std::size_t>(v * parts.columns + u)] = 1;
    }
  }
  return parts;
}

}  // namespace rastro
