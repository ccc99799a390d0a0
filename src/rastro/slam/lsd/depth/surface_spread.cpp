// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/surface_spread.h"

#include <array>

namespace rastro {

float surface_spread(const InverseDepthMap& depth, int x, int y) {
  constexpr std::array<std::array<int, 2>, 8> around{
      {{-2, 0}, {2, 0}, {0, -2}, {0, 2}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
  const float own = depth.mean.at(x, y), own_variance = depth.variance.at(x, y);
  float sum = 0.0F, count = 1.0F;
  for (const auto& [dx, dy] : around) {
    const int u = x + dx, v = y + dy;
    if (u < 0 || v < 0 || u >= depth.width() || v >= depth.height() || !depth.is_known(u, v)) continue;
    const float difference = depth.mean.at(u, v) - own, squared = difference * difference;
    count += 1.0F;
    if (squared > 4.0F * (own_variance + depth.variance.at(u, v))) sum += squared;
  }
  return sum / count;
}

}  // namespace rastro
