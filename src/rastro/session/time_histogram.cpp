// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/time_histogram.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

constexpr double lowest_ms = 1e-3;
constexpr double growth = 1.008;

}  // namespace

void TimeHistogram::add(double ms) {
  const double bin = std::log(std::max(ms, lowest_ms) / lowest_ms) / std::log(growth);
  ++bins_[std::min(static_cast<std::size_t>(bin), bins_.size() - 1)];
  ++count_;
  sum_ms_ += ms;
}

double TimeHistogram::percentile_ms(double share) const {
  const double wanted = share * static_cast<double>(count_);
  std::int64_t seen = 0;
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    seen += bins_[bin];
    if (seen > 0 && static_cast<double>(seen) >= wanted) {
      return lowest_ms * std::pow(growth, static_cast<double>(bin) + 0.5);
    }
  }
  return 0.0;
}

}  // namespace rastro
