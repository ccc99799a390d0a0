// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace rastro {

/// The update of the cells by one scan. The defaults are those of Hector SLAM (Kohlbrecher et al. 2011).
struct LogOddsModel {
  double occupied_probability = 0.9;  ///< Of a cell with a return, from this scan alone; above 0.5.
  double free_probability = 0.4;      ///< Of a cell a beam went through; below 0.5.
  double largest_log_odds = 6.0;      ///< Bound on the log-odds, so that a cell can still change.
};

/// The same in whole numbers: log-odds in steps of 1/256, probabilities from 0 (free) to 255 (occupied).
class LogOddsSteps {
 public:
  static constexpr std::uint8_t nothing_known = 128;  ///< The probability of log-odds 0.

  explicit LogOddsSteps(const LogOddsModel& model);

  std::int16_t after_return(std::int16_t log_odds) const { return limited(log_odds + occupied_step_); }
  std::int16_t after_passing_beam(std::int16_t log_odds) const { return limited(log_odds + free_step_); }
  std::uint8_t probability_of(std::int16_t log_odds) const {
    return probability_of_[static_cast<std::size_t>(log_odds + largest_)];
  }

 private:
  std::int16_t limited(int sum) const { return static_cast<std::int16_t>(std::clamp(sum, -largest_, largest_)); }

  int occupied_step_, free_step_, largest_;
  std::vector<std::uint8_t> probability_of_;  ///< Of each log-odds value from -largest_ on.
};

}  // namespace rastro
