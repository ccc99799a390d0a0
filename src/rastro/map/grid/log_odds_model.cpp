// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/grid/log_odds_model.h"

#include <cmath>
#include <limits>

namespace rastro {
namespace {

constexpr double steps = 256.0;
constexpr double largest_stored = std::numeric_limits<std::int16_t>::max();

int log_odds_step(double probability) {
  return static_cast<int>(std::lround(steps * std::log(probability / (1.0 - probability))));
}

}  // namespace

LogOddsSteps::LogOddsSteps(const LogOddsModel& model)
    : occupied_step_(log_odds_step(model.occupied_probability)),
      free_step_(log_odds_step(model.free_probability)),
      largest_(static_cast<int>(std::lround(std::min(steps * model.largest_log_odds, largest_stored)))) {
  for (int value = -largest_; value <= largest_; ++value) {
    const double probability = 1.0 / (1.0 + std::exp(-value / steps));
    probability_of_.push_back(static_cast<std::uint8_t>(std::lround(255.0 * probability)));
  }
}

}  // namespace rastro
