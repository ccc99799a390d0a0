// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace rastro {

/// Milliseconds between laps; for reports only, no result may depend on it.
class Stopwatch {
 public:
  double lap_ms() {
    const auto now = std::chrono::steady_clock::now();
    const double passed = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return passed;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace rastro
