// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>

#include "rastro/input_check/input_warning.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Stamps that go back: methods skip such frames. The same stamp again is a repeated frame, which recorders write.
class StampCheck {
 public:
  void add(const Frame& frame, InputWarnings& found);

 private:
  std::optional<TimeNs> latest_;
  bool said_ = false;
};

}  // namespace rastro
