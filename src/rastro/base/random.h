// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace rastro {

/// Seeded generator (SplitMix64) with the same numbers on every machine and standard library. Passed as an argument,
/// never global.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in 0 .. count-1; count > 0. The bias of 2^-32 of this multiply-shift is negligible for all uses here.
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(((next() >> 32) * count) >> 32); }
  /// Normal with mean 0 and standard deviation 1 (Box-Muller, one value per call, so that the state is one word).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t state_;
};

/// A well-mixed seed for an item of a stream (a frame, a pixel row), so that parallel items draw numbers independently
/// of order.
inline std::uint64_t seed_for(std::uint64_t seed, std::uint64_t item) {
  return Random(seed ^ (item * 0xD1B54A32D192ED03ULL)).next();
}

}  // namespace rastro
