// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Marks a function compiled for AVX2 whatever the build's flags; call it only if simd_level() allows it.
#define RASTRO_TARGET_AVX2 __attribute__((target("avx2,popcnt,bmi,bmi2")))

#if defined(__x86_64__)
#define RASTRO_HAS_AVX2_CODE 1
#else
#define RASTRO_HAS_AVX2_CODE 0
#endif

namespace rastro {

enum class SimdLevel { plain, avx2 };

/// The instruction set of the fast inner loops: the best of this processor, unless limited. Every level gives the same
/// bytes.
SimdLevel simd_level();
/// For tests and measurements: use at most this level from now on (never more than the processor has).
void limit_simd_level(SimdLevel level);

}  // namespace rastro
