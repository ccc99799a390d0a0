// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/stamp_check.h"

#include <algorithm>

namespace rastro {
namespace {

constexpr TimeNs surely_near = 10 * ns_per_second;
constexpr TimeNs longest_step = 24 * 3600 * ns_per_second;
constexpr TimeNs most_steps = 3;  // a recording may be slow as a whole

bool is_far_before(TimeNs stamp, TimeNs other) { return other > surely_near && stamp < other - surely_near; }

}  // namespace

StampCheck::Result StampCheck::check(TimeNs stamp) {
  if (last_ && stamp <= *last_) return check_before_last(stamp);
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

StampCheck::Result StampCheck::check_before_last(TimeNs stamp) {
  if (step_ > 0 || !is_far_before(stamp, *last_)) return Result::repeated;
  if (!behind_ || stamp <= *behind_) {
    behind_ = stamp;
    return Result::repeated;
  }
  step_ = std::min(stamp - *behind_, surely_near);
  first_ = *behind_ - step_;
  last_ = stamp;
  ahead_.reset();
  return Result::first_wrong;
}

}  // namespace rastro
