// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/fast.h"

#include <algorithm>
#include <array>
#include <bit>

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int lanes = 32;  // Rows are computed in whole vectors; every buffer has room for it.
constexpr int circle_x[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
constexpr int circle_y[16] = {3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1, 0, 1, 2, 3};
using Circle = std::array<std::ptrdiff_t, 16>;

Circle circle_of(std::ptrdiff_t stride) {
  Circle circle{};
  for (std::size_t i = 0; i < 16; ++i) circle[i] = circle_y[i] * stride + circle_x[i];
  return circle;
}

/// Maximum over the arcs of nine neighboring values on the circle of the minimum in the arc.
int best_arc(const int* differences) {
  int best = 0;
  for (int start = 0; start < 16; ++start) {
    int least = 255;
    for (int k = 0; k < 9; ++k) least = std::min(least, differences[(start + k) % 16]);
    best = std::max(best, least);
  }
  return best;
}

int score_of(const std::uint8_t* pixel, const Circle& circle, int threshold) {
  int brighter[16], darker[16];
  for (std::size_t i = 0; i < 16; ++i) {
    const int difference = pixel[circle[i]] - *pixel;
    brighter[i] = std::max(0, difference);
    darker[i] = std::max(0, -difference);
  }
  const int score = std::max(best_arc(brighter), best_arc(darker));
  return score > threshold ? score : 0;
}

/// Whether nine in a row can be brighter, or darker, by more than the threshold: of opposite pixels one must be.
bool can_be_corner(const std::uint8_t* pixel, const Circle& circle, int threshold) {
  bool brighter = true, darker = true;
  for (std::size_t i = 0; i < 8 && (brighter || darker); i += 2) {
    const int a = pixel[circle[i]] - *pixel, b = pixel[circle[i + 8]] - *pixel;
    brighter = brighter && (a > threshold || b > threshold);
    darker = darker && (a < -threshold || b < -threshold);
  }
  return brighter || darker;
}

void scores_plain(const std::uint8_t* row, const Circle& circle, int count, int threshold, std::uint8_t* scores) {
  for (int i = 0; i < count; ++i) {
    const bool worth = can_be_corner(row + i, circle, threshold);
    scores[i] = static_cast<std::uint8_t>(worth ? score_of(row + i, circle, threshold) : 0);
  }
}

/// Bit i: the score i of the middle row is a peak.
std::uint32_t peaks_plain(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int count) {
  std::uint32_t peaks = 0;
  for (int i = 0; i < count; ++i) {
    const std::uint8_t before = std::max({above[i - 1], above[i], above[i + 1], here[i - 1]});
    const std::uint8_t after = std::max({below[i - 1], below[i], below[i + 1], here[i + 1]});
    peaks |= static_cast<std::uint32_t>(here[i] > before && here[i] >= after) << i;
  }
  return peaks;
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 inline __m256i load(const std::uint8_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}

/// best_arc() of 32 pixels: eight shared in the middle of two arcs of nine, then the better of both ends.
RASTRO_TARGET_AVX2 inline __m256i best_arc_avx2(const __m256i* d) {
  __m256i two[8], four[8];
  for (int i = 0; i < 8; ++i) two[i] = _mm256_min_epu8(d[2 * i + 1], d[(2 * i + 2) % 16]);
  for (int i = 0; i < 8; ++i) four[i] = _mm256_min_epu8(two[i], two[(i + 1) % 8]);
  __m256i best = _mm256_setzero_si256();
  for (int i = 0; i < 8; ++i) {
    const __m256i eight = _mm256_min_epu8(four[i], four[(i + 2) % 8]);
    const __m256i end = _mm256_max_epu8(d[2 * i], d[(2 * i + 9) % 16]);
    best = _mm256_max_epu8(best, _mm256_min_epu8(eight, end));
  }
  return best;
}

/// Nonzero where nine in a row can differ by more than the threshold, judged by the four pixels right, left, above and
/// below.
RASTRO_TARGET_AVX2 inline __m256i worth_avx2(const std::uint8_t* pixels, const Circle& circle, __m256i center,
                                             __m256i threshold) {
  const __m256i up = load(pixels + circle[0]), right = load(pixels + circle[4]);
  const __m256i down = load(pixels + circle[8]), left = load(pixels + circle[12]);
  const __m256i high = _mm256_min_epu8(_mm256_max_epu8(up, down), _mm256_max_epu8(left, right));
  const __m256i low = _mm256_max_epu8(_mm256_min_epu8(up, down), _mm256_min_epu8(left, right));
  return _mm256_or_si256(_mm256_subs_epu8(_mm256_subs_epu8(high, center), threshold),
                         _mm256_subs_epu8(_mm256_subs_epu8(center, low), threshold));
}

RASTRO_TARGET_AVX2 void scores_avx2(const std::uint8_t* row, const Circle& circle, int count, int threshold,
                                    std::uint8_t* scores) {
  const __m256i least = _mm256_set1_epi8(static_cast<char>(threshold));
  const __m256i zero = _mm256_setzero_si256();
  for (int x = 0; x < count; x += lanes) {
    const __m256i center = load(row + x);
    __m256i score = zero;
    const __m256i worth = worth_avx2(row + x, circle, center, least);
    if (_mm256_testz_si256(worth, worth) == 0) {
      __m256i brighter[16], darker[16];
      for (std::size_t i = 0; i < 16; ++i) {
        const __m256i pixel = load(row + x + circle[i]);
        brighter[i] = _mm256_subs_epu8(pixel, center);
        darker[i] = _mm256_subs_epu8(center, pixel);
      }
      score = _mm256_max_epu8(best_arc_avx2(brighter), best_arc_avx2(darker));
      score = _mm256_andnot_si256(_mm256_cmpeq_epi8(_mm256_subs_epu8(score, least), zero), score);
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(scores + x), score);
  }
}

RASTRO_TARGET_AVX2 std::uint32_t peaks_avx2(const std::uint8_t* above, const std::uint8_t* here,
                                            const std::uint8_t* below) {
  const __m256i score = load(here);
  if (_mm256_testz_si256(score, score) != 0) return 0;
  const __m256i before =
      _mm256_max_epu8(_mm256_max_epu8(load(above - 1), load(above)), _mm256_max_epu8(load(above + 1), load(here - 1)));
  const __m256i after =
      _mm256_max_epu8(_mm256_max_epu8(load(below - 1), load(below)), _mm256_max_epu8(load(below + 1), load(here + 1)));
  const __m256i not_higher = _mm256_cmpeq_epi8(_mm256_subs_epu8(score, before), _mm256_setzero_si256());
  const __m256i not_lower = _mm256_cmpeq_epi8(_mm256_max_epu8(score, after), score);
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_andnot_si256(not_higher, not_lower)));
}
#endif

void scores_of_row(const std::uint8_t* row, const Circle& circle, int count, int threshold, std::uint8_t* scores) {
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) {
    scores_avx2(row, circle, count, threshold, scores);
    return;
  }
#endif
  scores_plain(row, circle, count, threshold, scores);
}

std::uint32_t peaks_of(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int count) {
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) {
    const std::uint32_t inside = count >= lanes ? ~0U : (1U << count) - 1U;
    return peaks_avx2(above, here, below) & inside;
  }
#endif
  return peaks_plain(above, here, below, std::min(count, lanes));
}

/// Appends the peaks of the row `y`, whose scores start one column left of x0.
void collect_peaks(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int x0, int count,
                   int y, std::vector<FastCorner>& corners) {
  for (int block = 0; block < count; block += lanes) {
    const int at = block + 1;
    for (std::uint32_t peaks = peaks_of(above + at, here + at, below + at, count - block); peaks; peaks &= peaks - 1) {
      const int i = at + std::countr_zero(peaks);
      corners.push_back({static_cast<std::int16_t>(x0 + i - 1), static_cast<std::int16_t>(y), here[i], here[i - 1],
                         here[i + 1], above[i], below[i]});
    }
  }
}

}  // namespace

void fast_corners(const PaddedImage& image, int x0, int x1, int y0, int y1, int threshold,
                  std::vector<FastCorner>& corners) {
  RASTRO_CHECK(image.padding() >= fast_padding, "vectors read beyond the area");
  const int count = x1 - x0;
  if (count <= 0 || y1 <= y0) return;
  const Circle circle = circle_of(image.stride());
  const std::size_t room = static_cast<std::size_t>(count) + 2 + 2 * lanes;
  std::vector<std::uint8_t> scores(3 * room);
  const auto row_of = [&](int y) { return scores.data() + static_cast<std::size_t>(y - y0 + 1) % 3 * room; };
  for (int y = y0 - 1; y <= y1; ++y) {
    scores_of_row(image.row(y) + x0 - 1, circle, count + 2, threshold, row_of(y));
    if (y > y0) collect_peaks(row_of(y - 2), row_of(y - 1), row_of(y), x0, count, y - 1, corners);
  }
}

}  // namespace rastro
