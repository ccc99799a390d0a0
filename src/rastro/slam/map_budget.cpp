// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/map_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace rastro {
namespace {

constexpr double bytes_per_megabyte = 1e6;
constexpr std::array<double, 4> stage_begins = {0.0, 0.5, 0.75, 0.9};  ///< Share of the budget.
constexpr std::array<double, 4> stage_spacing = {1.0, 1.5, 2.0, 3.0};
constexpr std::array<double, 4> stage_share = {1.0, 0.75, 0.5, 0.35};

}  // namespace

double MapBudget::spacing() const { return stage_spacing[static_cast<std::size_t>(stage_)]; }
double MapBudget::share() const { return stage_share[static_cast<std::size_t>(stage_)]; }

bool MapBudget::note(std::size_t used_bytes) {
  if (!limited()) return false;
  const double full = static_cast<double>(used_bytes) / static_cast<double>(bytes_);
  const int before = stage_;
  while (stage_ < 3 && full >= stage_begins[static_cast<std::size_t>(stage_) + 1]) ++stage_;
  return stage_ > before;
}

SlamEvent MapBudget::event(std::size_t used_bytes, const std::string& measures) const {
  return {"memory", fmt::format("the map uses {:.0f} % of its {:.1f} MB: {}",
                                100.0 * static_cast<double>(used_bytes) / static_cast<double>(bytes_),
                                static_cast<double>(bytes_) / bytes_per_megabyte, measures)};
}

std::size_t map_budget_bytes(const SlamContext& context, double reserve_mb) {
  if (context.map_memory_bytes > 0) return context.map_memory_bytes;
  if (context.max_memory_bytes == 0) return 0;
  constexpr double least_mb = 16.0;
  const double left_mb = static_cast<double>(context.max_memory_bytes) / bytes_per_megabyte - reserve_mb;
  return static_cast<std::size_t>(std::max(least_mb, left_mb) * bytes_per_megabyte);
}

}  // namespace rastro
