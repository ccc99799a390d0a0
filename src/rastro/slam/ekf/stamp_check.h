// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "rastro/base/time.h"

namespace rastro {

/// Tells frames by whose stamps time does not go on. A stamp far ahead waits for the next frame to confirm it: a wrong
/// one would make all frames after it look repeated.
class StampCheck {
 public:
  enum class Result : std::uint8_t {
    fits,
    repeated,  ///< Not after the last one that fits.
    ahead      ///< So far after it that the stamp may be wrong.
  };
  /// Of each frame in turn.
  Result check(TimeNs stamp);

 private:
  std::optional<TimeNs> last_;   ///< That fits.
  std::optional<TimeNs> ahead_;  ///< Not confirmed yet.
  TimeNs step_ = 0;              ///< Between the last two that fit.
};

}  // namespace rastro
