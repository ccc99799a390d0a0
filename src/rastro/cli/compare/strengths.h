// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rastro/cli/compare/compare_session.h"
#include "rastro/cli/compare/strength_curve.h"

namespace rastro::cli {

/// A disturbance with growing strengths.
struct StrengthLadder {
  std::string name;       ///< As --disturb of `rastro compare` takes it.
  std::string title;      ///< "covered camera".
  std::string unit;       ///< Of the strengths: "frames".
  std::string kind;       ///< Of the disturbance: "black".
  bool is_range = false;  ///< The strength is a number of frames from the middle of the run on.
  std::vector<double> strengths;
};

const std::vector<StrengthLadder>& strength_ladders();
/// "default": all; Error for an unknown name.
std::vector<StrengthLadder> ladders_named(const std::vector<std::string>& names);

/// NAME=VALUE of a strength; `middle`: the frame where a range begins.
std::string assignment_of(const StrengthLadder& ladder, double strength, std::int64_t middle);

/// Goes up each ladder with each method on each input, all side by side, until it loses track (less than 90 % of the
/// frames that it tracked without) or doubles its error. Runs are kept and resumed as all others. false: interrupted.
bool climb_ladders(const std::vector<StrengthLadder>& ladders, CompareSession& session,
                   std::vector<StrengthCurve>& curves);

}  // namespace rastro::cli
