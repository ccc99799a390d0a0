// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <thread>

#include "rastro/base/time.h"

namespace rastro {

/// Time as it passes, for what happens live. A test has one that it moves by hand.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Nanoseconds since some fixed instant; never steps back.
  virtual TimeNs now() const = 0;
  virtual void sleep_for(TimeNs duration) = 0;
};

/// The system's steady clock, of which CLOCK_MONOTONIC is the name that drivers use. Has no state: any thread may use
/// it.
class SteadyClock final : public Clock {
 public:
  TimeNs now() const override {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
  void sleep_for(TimeNs duration) override { std::this_thread::sleep_for(std::chrono::nanoseconds(duration)); }
};

}  // namespace rastro
