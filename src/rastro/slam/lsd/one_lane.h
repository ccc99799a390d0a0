// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

// One pixel at a time: the twin of eight_lanes.h. What is written once for both, in files *.inc, gives the same bytes
// with each, since all operations are rounded as IEEE 754 says.
namespace rastro::one_lane {

constexpr int width = 1;
using Reals = float;
using Integers = std::int32_t;
using Mask = bool;

inline Reals load(const float* values) { return *values; }
inline void store(Reals value, float* to) { *to = value; }
inline void store(Integers value, std::int32_t* to) { *to = value; }
inline Reals square_root(Reals value) { return std::sqrt(value); }
inline Reals absolute(Reals value) { return std::abs(value); }
inline Reals rounded_down(Reals value) { return std::floor(value); }
/// The second one if either is not a number, as of the processor's instructions.
inline Reals lesser(Reals a, Reals b) { return a < b ? a : b; }
inline Reals greater(Reals a, Reals b) { return a > b ? a : b; }
/// Of a value that an integer holds.
inline Integers truncated(Reals value) { return static_cast<Integers>(value); }
inline Reals real(Integers value) { return static_cast<Reals>(value); }
template <typename Value>
Value choose(Mask mask, Value yes, Value no) {
  return mask ? yes : no;
}
inline bool any(Mask mask) { return mask; }
/// The lowest bit is the first lane.
inline unsigned bits(Mask mask) { return mask ? 1U : 0U; }
/// from[0], from[2] and so on.
inline Reals every_second(const float* from) { return *from; }
inline float largest(Reals value) { return value; }

/// Bytes at the offset, and one or two further.
struct Neighbors {
  Reals first, second, third;
};
inline Neighbors neighbors_at(const std::uint8_t* base, Integers offset) {
  const std::uint8_t* pixel = base + offset;
  return {static_cast<float>(pixel[0]), static_cast<float>(pixel[1]), static_cast<float>(pixel[2])};
}

}  // namespace rastro::one_lane
