// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "rastro/base/error.h"

namespace rastro {

/// The median of values in any order; of an even number the greater of the two in the middle, so that it is always one
/// of the values. There must be at least one.
template <typename Value>
Value upper_median(std::vector<Value> values) {
  RASTRO_CHECK(!values.empty(), "a median needs at least one value");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The same, or `otherwise` if there are no values.
template <typename Value>
Value upper_median_or(std::vector<Value> values, Value otherwise) {
  return values.empty() ? otherwise : upper_median(std::move(values));
}

/// The median of values in any order; of an even number the mean of the two in the middle. There must be at least one.
inline double median(std::vector<double> values) {
  RASTRO_CHECK(!values.empty(), "a median needs at least one value");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

struct WeightedValue {
  double value = 0.0, weight = 1.0;
};

/// The value with half of the weights on either side, which minimizes the weighted sum of the distances to it. There
/// must be at least one, and no weight below zero.
inline double weighted_median(std::vector<WeightedValue> values) {
  RASTRO_CHECK(!values.empty(), "a median needs at least one value");
  std::sort(values.begin(), values.end(),
            [](const WeightedValue& a, const WeightedValue& b) { return a.value < b.value; });
  double whole = 0.0, below = 0.0;
  for (const WeightedValue& each : values) whole += each.weight;
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    below += values[i].weight;
    if (below == 0.5 * whole) return 0.5 * (values[i].value + values[i + 1].value);
    if (below > 0.5 * whole) return values[i].value;
  }
  return values.back().value;
}

}  // namespace rastro
