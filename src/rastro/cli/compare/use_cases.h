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
/// without depth below that, a phone by methods of one camera below that, a robot by its laser. Of the methods with
/// at most twice the error of the mark and within 5 points of its completion (MarkOnInput), that with the smallest
/// error is recommended: as ratio to the mark on each input, geometric mean over the inputs. On each input only those
/// are judged that are ranked_together().
std::vector<UseCaseAdvice> use_case_advice(const Comparison& comparison,
                                           const std::vector<PairedDifference>& differences);

}  // namespace rastro::cli
