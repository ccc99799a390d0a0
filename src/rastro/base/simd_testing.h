// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/base/simd.h"

namespace rastro::testing {

/// Runs `work` with the plain inner loops, whatever the processor has.
template <typename Work>
auto with_plain_code(Work&& work) {
  struct Limit {
    Limit() { limit_simd_level(SimdLevel::plain); }
    ~Limit() { limit_simd_level(SimdLevel::avx2); }
  } limit;
  return work();
}

}  // namespace rastro::testing
