// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/paired_significance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace rastro {
namespace {

constexpr std::size_t most_counted = 60;

/// Twice the rank of each difference by its size, which is whole also where equal ones share a mean rank.
struct DoubledRanks {
  std::vector<std::size_t> ranks;
  std::size_t positive_sum = 0;
  double tie_correction = 0.0;  ///< Sum of t^3 - t over groups of t equal sizes.
};

DoubledRanks ranked(std::vector<double> differences) {
  std::erase(differences, 0.0);
  std::sort(differences.begin(), differences.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  DoubledRanks all;
  for (std::size_t first = 0, end = 0; first < differences.size(); first = end) {
    while (end < differences.size() && std::abs(differences[end]) == std::abs(differences[first])) ++end;
    const std::size_t doubled = first + 1 + end;  // ranks first + 1 to end: twice their mean
    const auto equal = static_cast<double>(end - first);
    all.tie_correction += equal * equal * equal - equal;
    for (std::size_t k = first; k < end; ++k) {
      all.ranks.push_back(doubled);
      if (differences[k] > 0.0) all.positive_sum += doubled;
    }
  }
  return all;
}

/// Share of all choices of signs whose positive ranks sum to at most `limit`.
double share_up_to(const std::vector<std::size_t>& ranks, std::size_t limit) {
  const std::size_t total = std::accumulate(ranks.begin(), ranks.end(), std::size_t{0});
  std::vector<double> share(total + 1, 0.0);
  share[0] = 1.0;
  for (const std::size_t rank : ranks) {
    for (std::size_t sum = total + 1; sum-- > 0;)
      share[sum] = 0.5 * (share[sum] + (sum >= rank ? share[sum - rank] : 0.0));
  }
  return std::accumulate(share.begin(), share.begin() + static_cast<std::ptrdiff_t>(limit) + 1, 0.0);
}

double normal_p_value(const DoubledRanks& all) {
  const auto n = static_cast<double>(all.ranks.size());
  const double mean = n * (n + 1.0) / 4.0;
  const double variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - all.tie_correction / 48.0;
  const double off = std::max(0.0, std::abs(0.5 * static_cast<double>(all.positive_sum) - mean) - 0.5);
  return std::erfc(off / std::sqrt(2.0 * variance));
}

}  // namespace

double signed_rank_p_value(const std::vector<double>& differences) {
  const DoubledRanks all = ranked(differences);
  if (all.ranks.empty()) return 1.0;
  if (all.ranks.size() > most_counted) return normal_p_value(all);
  const std::size_t total = std::accumulate(all.ranks.begin(), all.ranks.end(), std::size_t{0});
  return std::min(1.0, 2.0 * share_up_to(all.ranks, std::min(all.positive_sum, total - all.positive_sum)));
}

std::vector<double> holm_adjusted(const std::vector<double>& p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0.0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    largest = std::max(largest, static_cast<double>(order.size() - k) * p_values[order[k]]);
    adjusted[order[k]] = std::min(1.0, largest);
  }
  return adjusted;
}

}  // namespace rastro
