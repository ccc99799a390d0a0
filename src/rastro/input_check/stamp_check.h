// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>

#include "rastro/input_check/input_warning.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Stamps of images that go back: most methods do not use a frame that is earlier than the one before. The same stamp
/// again is a repeated frame, which recorders write; scans of laser logs are out of order now and then.
class StampCheck {
 public:
  void add(const Frame& frame, InputWarnings& found);

 private:
  std::optional<TimeNs> last_;
  bool said_ = false;
};

}  // namespace rastro
