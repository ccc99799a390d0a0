// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// The memory budget of a map: the fuller it is, the more sparingly a method adds to the map. It counts only the bytes
/// that the method reports, so every run does the same.
class MapBudget {
 public:
  explicit MapBudget(std::size_t bytes = 0) : bytes_(bytes) {}

  bool limited() const { return bytes_ > 0; }
  std::size_t bytes() const { return bytes_; }
  /// 0 below half the budget, 1 from 50 %, 2 from 75 %, 3 from 90 % on; never falls.
  int stage() const { return stage_; }
  /// Share of the budget from which redundant data is freed.
  static constexpr double full_share = 0.9;
  std::size_t full_bytes() const { return bytes_ / 10 * 9; }
  /// Factor on the usual motion between keyframes: 1, 1.5, 2, 3.
  double spacing() const;
  /// Factor on the usual number of features: 1, 0.75, 0.5, 0.35.
  double share() const;
  /// Records the map's current size; returns whether a new stage begins.
  bool note(std::size_t used_bytes);
  /// An event of kind "memory"; `measures` says what is done.
  SlamEvent event(std::size_t used_bytes, const std::string& measures) const;

 private:
  std::size_t bytes_;
  int stage_ = 0;
};

/// The map's budget from a context: its own, or what remains of the program's memory limit above `reserve_mb` (10^6
/// bytes), at least 16 MB; 0: unlimited.
std::size_t map_budget_bytes(const SlamContext& context, double reserve_mb);

}  // namespace rastro
