// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/stamp_check.h"

#include <algorithm>

namespace rastro {
namespace {

constexpr TimeNs surely_near = 10 * ns_per_second;
constexpr TimeNs longest_step = 24 * 3600 * ns_per_second;
constexpr TimeNs most_steps = 3;  // a recording may be slow as a whole

}  // namespace

StampCheck::Result StampCheck::check(TimeNs stamp) {
  if (last_ && stamp <= *last_) return Result::repeated;
  const TimeNs step = last_ ? stamp - *last_ : 0;
  const bool confirmed = ahead_ && stamp > *ahead_;
  if (step > std::max(surely_near, most_steps * step_) && !confirmed) {
    ahead_ = stamp;
    return Result::ahead;
  }
  ahead_.reset();
  last_ = stamp;
  step_ = std::min(step, longest_step);
  return Result::fits;
}

}  // namespace rastro
