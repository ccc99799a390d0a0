// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/depth/surface_spread.h"

#include <array>

namespace rastro {
namespace {

/// Eight neighbors at each distance: along rows and columns, and on the diagonals.
struct Ring {
  int straight, diagonal;
};
constexpr std::array<Ring, 3> rings{{{2, 1}, {4, 3}, {6, 4}}};

}  // namespace

float surface_spread(const InverseDepthMap& depth, int x, int y) {
  const float own = depth.mean.at(x, y), own_variance = depth.variance.at(x, y);
  float sum = 0.0F, count = 1.0F;
  const auto add = [&](int u, int v) {
    if (u < 0 || v < 0 || u >= depth.width() || v >= depth.height() || !depth.is_known(u, v)) return;
    const float difference = depth.mean.at(u, v) - own, squared = difference * difference;
    count += 1.0F;
    if (squared > 4.0F * (own_variance + depth.variance.at(u, v))) sum += squared;
  };
  for (const auto& [straight, diagonal] : rings)
    for (const int sign : {-1, 1}) {
      add(x + sign * straight, y);
      add(x, y + sign * straight);
      add(x + sign * diagonal, y - diagonal);
      add(x + sign * diagonal, y + diagonal);
    }
  return sum / count;
}

}  // namespace rastro
