// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/dataset/check.h"

namespace rastro {

/// The frames' numbers and stamps, whether they could be read or not. Internal to the dataset module.
struct FrameStamps {
  std::vector<std::int64_t> frames;
  std::vector<TimeNs> stamps;
};

/// Of the steps forward; 0 without any.
TimeNs median_forward_step(const std::vector<TimeNs>& stamps);

/// What the findings and the stamps mean: warnings, and the reasons why a recording cannot be used.
void judge(CheckReport& report, const FrameStamps& all);

}  // namespace rastro
