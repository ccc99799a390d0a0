// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace rastro {

/// Share of the ratios that differ from `center` by less than 15 % of it; `ratios` must not be empty.
inline double share_near(const std::vector<double>& ratios, double center) {
  constexpr double spread = 0.15;
  const auto near = std::count_if(ratios.begin(), ratios.end(),
                                  [&](double ratio) { return std::abs(ratio / center - 1.0) < spread; });
  return static_cast<double>(near) / static_cast<double>(ratios.size());
}

}  // namespace rastro
