// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rastro/cli/compare/comparison.h"
#include "rastro/cli/compare/paired_differences.h"

namespace rastro::cli {

/// What to use for one kind of job, in words.
struct UseCaseAdvice {
  std::string title;
  std::string text;
};

/// A paragraph per use case. Inputs belong to a use case by their sensors and by the speed of their ground truth, never
/// by name: a hand-held depth camera by its depth images, a car by cameras at 3 m/s or more, a drone by cameras
/// without depth below that, a phone by methods of one camera below that, a robot by its laser. Of the methods that
/// complete within 5 points of the most complete one, that with the smallest error, as ratio to the best on each input
/// and geometric mean over them, is recommended.
std::vector<UseCaseAdvice> use_case_advice(const Comparison& comparison,
                                           const std::vector<PairedDifference>& differences);

}  // namespace rastro::cli
