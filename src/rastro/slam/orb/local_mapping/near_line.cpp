// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/near_line.h"

#include <bit>

#include "rastro/base/error.h"
#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

/// Starts at `first`; `used` is the next output index. Returns the new `used`.
std::size_t near_line_plain(const float* x, const float* y, const float* limit, std::size_t first, std::size_t count,
                            float a, float b, float c, std::size_t used, std::uint32_t* found) {
  for (std::size_t i = first; i < count; ++i) {
    const float distance = a * x[i] + b * y[i] + c;
    found[used] = static_cast<std::uint32_t>(i);
    used += static_cast<std::size_t>(distance * distance < limit[i]);
  }
  return used;
}

#if RASTRO_HAS_AVX2_CODE
/// As many whole vectors as there are, 8 positions each.
RASTRO_TARGET_AVX2 std::size_t near_line_avx2(const float* x, const float* y, const float* limit, std::size_t count,
                                              float a, float b, float c, std::uint32_t* found) {
  const __m256 as = _mm256_set1_ps(a), bs = _mm256_set1_ps(b), cs = _mm256_set1_ps(c);
  std::size_t used = 0;
  for (std::size_t i = 0; i + 8 <= count; i += 8) {
    const __m256 along_x = _mm256_mul_ps(as, _mm256_loadu_ps(x + i));
    const __m256 along_y = _mm256_mul_ps(bs, _mm256_loadu_ps(y + i));
    const __m256 distance = _mm256_add_ps(_mm256_add_ps(along_x, along_y), cs);
    const __m256 near = _mm256_cmp_ps(_mm256_mul_ps(distance, distance), _mm256_loadu_ps(limit + i), _CMP_LT_OQ);
    for (auto bits = static_cast<std::uint32_t>(_mm256_movemask_ps(near)); bits != 0; bits &= bits - 1)
      found[used++] = static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(std::countr_zero(bits));
  }
  return used;
}
#endif

}  // namespace

void find_near_line(std::span<const float> x, std::span<const float> y, std::span<const float> squared_limit, float a,
                    float b, float c, std::vector<std::uint32_t>& found) {
  const std::size_t count = x.size();
  RASTRO_CHECK(y.size() == count && squared_limit.size() == count, "lists of one length");
  found.resize(count + 1);  // the plain loop writes first and decides afterwards
  std::size_t first = 0, used = 0;
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) {
    used = near_line_avx2(x.data(), y.data(), squared_limit.data(), count, a, b, c, found.data());
    first = count / 8 * 8;
  }
#endif
  found.resize(near_line_plain(x.data(), y.data(), squared_limit.data(), first, count, a, b, c, used, found.data()));
}

}  // namespace rastro
