// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/stamp_check.h"

#include <fmt/format.h>

namespace rastro {

void StampCheck::add(const Frame& frame, InputWarnings& found) {
  if (frame.image.empty()) return;
  if (last_ && frame.stamp < *last_ && !said_) {
    said_ = true;
    found.push_back(
        {"stamps_backward",
         fmt::format("the stamps go back: frame {} is {:.3g} s earlier than the one before; most methods do "
                     "not use such frames, `rastro check` lists them",
                     frame.index, to_seconds(*last_ - frame.stamp))});
  }
  last_ = frame.stamp;
}

}  // namespace rastro
