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

}  // namespace rastro
