// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <algorithm>
#include <cstdint>

namespace rastro {

/// Which frames of a run are looked at: close together at first, so that a short recording has enough, then ever rarer.
class SampleSchedule {
 public:
  SampleSchedule(std::int64_t first, double step, double growth, double longest_step)
      : next_(first), step_(step), growth_(growth), longest_step_(longest_step) {}

  /// In the order of the frames, `number` counted from 0.
  bool is_due(std::int64_t number) const { return number >= next_; }
  /// After a sample at `number`.
  void taken(std::int64_t number) {
    next_ = number + static_cast<std::int64_t>(step_);
    step_ = std::min(longest_step_, step_ * growth_);
  }

 private:
  std::int64_t next_;
  double step_, growth_, longest_step_;
};

/// For what needs frames in a row: all of the first ones, then one in five, in bursts.
inline bool is_in_burst(std::int64_t number) { return number < 240 || number % 200 < 40; }

}  // namespace rastro
