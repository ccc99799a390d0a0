// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace rastro {

/// Standard deviation of an estimate over `count` ordered measurements, from the estimates without one eighth of them
/// each: estimate_without(begin, end). Leaves out blocks rather than single measurements because the errors of
/// neighbors are correlated (block jackknife; Efron and Tibshirani 1993, chapter 11). 0 if no estimate is left without
/// a block.
template <typename Estimate>
double jackknife_sigma(std::size_t count, const Estimate& estimate_without) {
  constexpr std::size_t blocks = 8;
  std::vector<double> values;
  for (std::size_t block = 0; block < blocks; ++block)
    if (const auto value = estimate_without(count * block / blocks, count * (block + 1) / blocks))
      values.push_back(*value);
  if (values.size() < 2) return 0.0;
  const auto used = static_cast<double>(values.size());
  double mean = 0.0, squares = 0.0;
  for (const double value : values) mean += value / used;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt((used - 1.0) / used * squares);
}

}  // namespace rastro
