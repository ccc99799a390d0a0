// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "rastro/base/time.h"

namespace rastro {

/// Tells frames by whose stamps time does not go on. A stamp far ahead waits for the next frame to confirm it: a wrong
/// one would make all frames after it look repeated. So would the first frame, which is taken as it is: two frames far
/// before it tell that its own stamp is the wrong one.
class StampCheck {
 public:
  enum class Result : std::uint8_t {
    fits,
    repeated,    ///< Not after the last one that fits.
    ahead,       ///< So far after it that the stamp may be wrong.
    first_wrong  ///< Fits, unlike that of the first frame, which was the only one that did; see first().
  };
  /// Of each frame in turn.
  Result check(TimeNs stamp);
  /// After Result::first_wrong: about when the first frame was, one step before the second.
  TimeNs first() const { return first_; }

 private:
  Result check_before_last(TimeNs stamp);

  std::optional<TimeNs> last_;    ///< That fits.
  std::optional<TimeNs> ahead_;   ///< Not confirmed yet.
  std::optional<TimeNs> behind_;  ///< Far before the first one, not confirmed yet.
  TimeNs first_ = 0;
  TimeNs step_ = 0;  ///< Between the last two that fit; 0 at the first.
};

}  // namespace rastro
