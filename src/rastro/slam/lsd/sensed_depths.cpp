// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/sensed_depths.h"

#include <algorithm>
#include <cmath>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr int border_px = 4;
constexpr std::size_t least_ratios = 500;
constexpr int rounds = 20;

}  // namespace

int cell_for(int points, int width, int height) {
  const int side = static_cast<int>(std::sqrt(1.0 * width * height / points));
  return std::max(2, side - side % 2);
}

int squared_gradient(GrayView image, int x, int y) {
  const int across = image.at(x + 1, y) - image.at(x - 1, y), upright = image.at(x, y + 1) - image.at(x, y - 1);
  return across * across + upright * upright;
}

void SensedDepthMap::note(const EpipolarQueries& queries, const EpipolarMatches& matches) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(queries.count); ++i) {
    if (matches.result[i] != static_cast<std::int32_t>(EpipolarResult::matched)) continue;
    const auto x = static_cast<int>(queries.x[i]), y = static_cast<int>(queries.y[i]);
    depth_.mean.at(x, y) = matches.mean[i];
    depth_.variance.at(x, y) = matches.variance[i];
  }
}

std::vector<SensedDepth> SensedDepthMap::thinned(GrayView image, int cell_px) const {
  std::vector<SensedDepth> chosen;
  for (int top = border_px; top + cell_px + border_px < image.height; top += cell_px) {
    for (int left = border_px; left + cell_px + border_px < image.width; left += cell_px) {
      int best = 0;
      SensedDepth sensed;
      for (int y = top; y < top + cell_px; ++y)
        for (int x = left; x < left + cell_px; ++x) {
          if (!depth_.is_known(x, y)) continue;
          const int gradient = squared_gradient(image, x, y);
          if (gradient <= best) continue;
          best = gradient;
          sensed = {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), depth_.mean.at(x, y),
                    std::sqrt(depth_.variance.at(x, y))};
        }
      if (best > 0) chosen.push_back(sensed);
    }
  }
  return chosen;
}

double sensed_scale(const std::vector<DepthRatio>& ratios) {
  std::vector<double> logarithms, sizes;
  for (const DepthRatio& one : ratios)
    if (one.sensed > 0.0 && one.of_map > 0.0) logarithms.push_back(std::log(one.sensed / one.of_map));
  if (logarithms.size() < least_ratios) return 1.0;
  double scale = median(logarithms);
  const auto sigma_of = [](const DepthRatio& one) { return one.sensed_sigma / one.sensed; };
  for (const DepthRatio& one : ratios)
    if (one.sensed > 0.0 && one.of_map > 0.0)
      sizes.push_back(std::abs(std::log(one.sensed / one.of_map) - scale) / sigma_of(one));
  const double width = std::max(1e-6, 1.4826 * median(sizes));
  for (int round = 0; round < rounds; ++round) {  // Cauchy's weights
    double sum = 0.0, weights = 0.0;
    for (const DepthRatio& one : ratios) {
      if (!(one.sensed > 0.0 && one.of_map > 0.0)) continue;
      const double sigma = sigma_of(one), logarithm = std::log(one.sensed / one.of_map);
      const double error = (logarithm - scale) / (sigma * width);
      const double weight = 1.0 / (sigma * sigma * (1.0 + error * error));
      sum += weight * logarithm, weights += weight;
    }
    scale = sum / weights;
  }
  return std::exp(scale);
}

}  // namespace rastro
