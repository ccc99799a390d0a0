// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/inverse_depth_pyramid.h"

#include <algorithm>

namespace rastro {
namespace {

/// Weighted sums of the pixels that contribute to each pixel of the coarser level.
struct DepthSums {
  InverseDepthMap weighted;  ///< mean: sum of weight / variance * value; variance: sum of weight / variance.
  Image<float> squares;      ///< Sum of weight / variance * value^2.
  Image<float> weights;      ///< Sum of the binomial weights.

  /// The products of one pixel, the same for each pixel it contributes to.
  struct Share {
    float precision, weighted, squared, weight;
  };

  void add(int x, int y, const Share& share) {
    if (x >= weights.width() || y >= weights.height()) return;
    weighted.mean.at(x, y) += share.weighted;
    weighted.variance.at(x, y) += share.precision;
    squares.at(x, y) += share.squared;
    weights.at(x, y) += share.weight;
  }
};

/// An even coordinate belongs to one of the coarser level, an odd one to both beside it.
void scatter(const InverseDepthMap& fine, int x, int y, DepthSums& sums) {
  const float value = fine.mean.at(x, y), weight = static_cast<float>((2 - (x & 1)) * (2 - (y & 1)));
  const float precision = weight / fine.variance.at(x, y);
  const DepthSums::Share share{precision, precision * value, precision * value * value, weight};
  for (int to_y = y / 2; to_y <= (y + 1) / 2; ++to_y) {
    for (int to_x = x / 2; to_x <= (x + 1) / 2; ++to_x) sums.add(to_x, to_y, share);
  }
}

void divide_sums(DepthSums& sums) {
  for (int y = 0; y < sums.weights.height(); ++y) {
    for (int x = 0; x < sums.weights.width(); ++x) {
      float &mean = sums.weighted.mean.at(x, y), &variance = sums.weighted.variance.at(x, y);
      if (!(variance > 0.0F)) continue;
      mean /= variance;
      const float spread = sums.squares.at(x, y) / variance - mean * mean;
      variance = std::max(sums.weights.at(x, y) / variance, spread);
    }
  }
}

}  // namespace

InverseDepthMap halve(const InverseDepthMap& fine) {
  const int width = (fine.width() + 1) / 2, height = (fine.height() + 1) / 2;
  DepthSums sums{InverseDepthMap(width, height), Image<float>(width, height), Image<float>(width, height)};
  for (int y = 0; y < fine.height(); ++y) {
    for (int x = 0; x < fine.width(); ++x) {
      if (fine.is_known(x, y)) scatter(fine, x, y, sums);
    }
  }
  divide_sums(sums);
  return std::move(sums.weighted);
}

std::vector<InverseDepthMap> inverse_depth_pyramid(const InverseDepthMap& map, int levels) {
  RASTRO_CHECK(levels >= 1, "a pyramid has a level");
  std::vector<InverseDepthMap> pyramid{map};
  while (static_cast<int>(pyramid.size()) < levels) pyramid.push_back(halve(pyramid.back()));
  return pyramid;
}

}  // namespace rastro
