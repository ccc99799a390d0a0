// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/simd.h"

#include <atomic>

namespace rastro {
namespace {

SimdLevel best_level() {
#if RASTRO_HAS_AVX2_CODE
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt") ? SimdLevel::avx2 : SimdLevel::plain;
#else
  return SimdLevel::plain;
#endif
}

std::atomic<SimdLevel>& level() {
  static std::atomic<SimdLevel> current = best_level();
  return current;
}

}  // namespace

SimdLevel simd_level() { return level().load(std::memory_order_relaxed); }

void limit_simd_level(SimdLevel limit) { level() = best_level() == SimdLevel::avx2 ? limit : SimdLevel::plain; }

}  // namespace rastro
