// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace rastro::cli {

/// A method under one strength of a disturbance, beside the run without it.
struct StrengthStep {
  double strength = 0.0;
  std::string assignment;                  ///< NAME=VALUE, as --disturb takes it.
  std::optional<double> completion_ratio;  ///< Of the frames outside of a covered part.
  std::optional<double> error_ratio;       ///< ATE by that without.
  std::optional<double> recovery_s;        ///< From the end of a covered or missing part to the next tracked frame.
  bool warned = false;
  std::string
      failure;  ///< "loses track", "doubles its error", "refuses the input" or why the run failed; empty: holds.
  std::string command;
};

/// How one method on one input takes a growing disturbance: steps up to the first that fails.
struct StrengthCurve {
  std::size_t input = 0;
  std::string column;
  std::string disturbance;  ///< Name of its ladder.
  std::vector<StrengthStep> steps;

  /// The first step that fails; nullptr: it holds all that were tried.
  const StrengthStep* failure() const {
    return steps.empty() || steps.back().failure.empty() ? nullptr : &steps.back();
  }
};

}  // namespace rastro::cli
