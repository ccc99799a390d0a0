// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

namespace rastro {

/// Time of a measurement in nanoseconds since the recording's epoch.
using TimeNs = std::int64_t;

constexpr TimeNs ns_per_second = 1'000'000'000;
inline double to_seconds(TimeNs time) { return static_cast<double>(time) * 1e-9; }
inline TimeNs from_seconds(double seconds) { return static_cast<TimeNs>(std::llround(seconds * 1e9)); }

}  // namespace rastro
