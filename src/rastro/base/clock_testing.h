// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "rastro/base/clock.h"

namespace rastro {

/// Stands still but for what it sleeps or is moved by.
class FakeClock final : public Clock {
 public:
  TimeNs now() const override { return now_.load(); }
  void sleep_for(TimeNs duration) override { now_ += duration; }
  void move(TimeNs by) { now_ += by; }

 private:
  std::atomic<TimeNs> now_ = 1000 * ns_per_second;
};

}  // namespace rastro
