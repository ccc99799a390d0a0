// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "rastro/base/random.h"
#include "rastro/feature/orb_describe.h"

namespace rastro {
namespace {

OrbPattern draw_pattern() {
  Random random(1);
  OrbPattern pattern{};
  const auto draw = [&](std::int8_t& x, std::int8_t& y) {
    int dx = 0, dy = 0;
    do {
      dx = static_cast<int>(std::lround(6.2 * random.normal()));
      dy = static_cast<int>(std::lround(6.2 * random.normal()));
    } while (dx * dx + dy * dy > 14 * 14);
    x = static_cast<std::int8_t>(dx);
    y = static_cast<std::int8_t>(dy);
  };
  for (auto& test : pattern) {
    do {
      draw(test[0], test[1]);
      draw(test[2], test[3]);
    } while (test[0] == test[2] && test[1] == test[3]);
  }
  return pattern;
}

}  // namespace

const OrbPattern& orb_pattern() {
  static const OrbPattern pattern = draw_pattern();
  return pattern;
}

}  // namespace rastro
