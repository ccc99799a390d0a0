// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/base/time.h"

namespace rastro {

/// 146 years: differences of two stamps then never overflow.
constexpr TimeNs largest_stamp = 4'600'000'000'000'000'000;

enum class StampUnit { seconds, milliseconds, microseconds, nanoseconds };

std::string_view unit_name(StampUnit unit);

/// A decimal number ("1305031239.529662", "1.037e-01", "1403715285262142976") of `unit`, exact to the nanosecond: a
/// double would be wrong by a hundred. nullopt if it is not a finite number or outside int64 nanoseconds (292 years).
std::optional<TimeNs> parse_stamp(std::string_view text, StampUnit unit);

/// The stamp in seconds with nine digits after the point, exact: "1305031239.529662000".
std::string seconds_text(TimeNs stamp);

/// "2011-09-26 13:02:25.964389445" (taken as UTC), as KITTI raw writes it.
std::optional<TimeNs> parse_date_stamp(std::string_view text);

/// The most likely unit of a list of stamps. `native` (the format's unit) is kept unless the numbers are a date between
/// 1980 and 2100 in another unit with a plausible step, or their median step is implausible for a camera (outside 0.5
/// ms to 20 s).
StampUnit guess_stamp_unit(std::span<const double> stamps, StampUnit native);

}  // namespace rastro
