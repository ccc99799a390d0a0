// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/stamp_check.h"

#include <fmt/format.h>

#include <algorithm>

namespace rastro {

void StampCheck::add(const Frame& frame, InputWarnings& found) {
  if (latest_ && frame.stamp < *latest_ && !said_) {
    said_ = true;
    found.push_back({"stamps_backward",
                     fmt::format("the stamps go back: frame {} is {:.3g} s earlier than one before it; such frames are "
                                 "skipped, `rastro check` lists them",
                                 frame.index, to_seconds(*latest_ - frame.stamp))});
  }
  latest_ = std::max(latest_.value_or(frame.stamp), frame.stamp);
}

}  // namespace rastro
