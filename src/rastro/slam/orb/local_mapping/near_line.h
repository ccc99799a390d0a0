// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace rastro {

/// Finds the positions near the line a x + b y + c = 0, a^2 + b^2 = 1: indices i, ascending, with (a x[i] + b y[i] +
/// c)^2 < squared_limit[i]. The three lists have the same length.
void find_near_line(std::span<const float> x, std::span<const float> y, std::span<const float> squared_limit, float a,
                    float b, float c, std::vector<std::uint32_t>& found);

}  // namespace rastro
