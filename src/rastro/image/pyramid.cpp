// SPDX-License-Identifier: Apache-2.0
#include "rastro/image/pyramid.h"

#include <algorithm>

#include "rastro/base/simd.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int smallest_side = 8;
constexpr int rows_per_chunk = 32;

/// The five source rows around an output row.
struct RowsAround {
  const std::uint8_t* row[5];
};

/// columns[x + 2] = vertical [1 4 6 4 1] sum at x, for x from -2 to width + 1 (rounded up to a multiple of 16 from -2).
void filter_columns_plain(const RowsAround& rows, int count, std::uint16_t* columns) {
  for (int i = 0; i < count; ++i) {
    const auto at = [&](int r) { return static_cast<int>(rows.row[r][i - 2]); };
    columns[i] = static_cast<std::uint16_t>(at(0) + at(4) + 4 * (at(1) + at(3)) + 6 * at(2));
  }
}

void filter_and_halve_row_plain(const std::uint16_t* columns, int width, std::uint8_t* out) {
  for (int x = 0; x < width; ++x) {
    const std::uint16_t* c = columns + 2 * x;
    out[x] = static_cast<std::uint8_t>((c[0] + c[4] + 4 * (c[1] + c[3]) + 6 * c[2] + 128) >> 8);
  }
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 __m256i load_wide(const std::uint8_t* p) {
  return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
}

RASTRO_TARGET_AVX2 void filter_columns_avx2(const RowsAround& rows, int count, std::uint16_t* columns) {
  for (int i = 0; i < count; i += 16) {
    const __m256i outer = _mm256_add_epi16(load_wide(rows.row[0] + i - 2), load_wide(rows.row[4] + i - 2));
    const __m256i inner = _mm256_add_epi16(load_wide(rows.row[1] + i - 2), load_wide(rows.row[3] + i - 2));
    const __m256i middle = load_wide(rows.row[2] + i - 2);
    const __m256i four = _mm256_slli_epi16(_mm256_add_epi16(inner, middle), 2);
    const __m256i sum = _mm256_add_epi16(_mm256_add_epi16(outer, four), _mm256_add_epi16(middle, middle));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(columns + i), sum);
  }
}

RASTRO_TARGET_AVX2 __m256i halved_8(const std::uint16_t* c) {
  const auto load = [](const std::uint16_t* p) __attribute__((target("avx2"))) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
  };
  const __m256i left = _mm256_madd_epi16(load(c), _mm256_set1_epi32(0x00040001));
  const __m256i middle = _mm256_madd_epi16(load(c + 2), _mm256_set1_epi32(0x00040006));
  const __m256i right = _mm256_madd_epi16(load(c + 4), _mm256_set1_epi32(0x00000001));
  const __m256i sum = _mm256_add_epi32(_mm256_add_epi32(left, middle), _mm256_add_epi32(right, _mm256_set1_epi32(128)));
  return _mm256_srli_epi32(sum, 8);
}

RASTRO_TARGET_AVX2 void filter_and_halve_row_avx2(const std::uint16_t* columns, int width, std::uint8_t* out) {
  int x = 0;
  for (; x + 16 <= width; x += 16) {
    const __m256i words = _mm256_permute4x64_epi64(
        _mm256_packus_epi32(halved_8(columns + 2 * x), halved_8(columns + 2 * x + 16)), 0b11011000);
    const __m128i bytes = _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + x), bytes);
  }
  filter_and_halve_row_plain(columns + 2 * x, width - x, out + x);
}
#endif

void halve_rows(const PaddedImage& source, PaddedImage& target, int begin, int end) {
  const int count = source.width() + 4;
  // Room for the vectors' tail behind the last column.
  std::vector<std::uint16_t> columns(static_cast<std::size_t>(count) + 64);
  for (int y = begin; y < end; ++y) {
    RowsAround rows{};
    for (int r = 0; r < 5; ++r) rows.row[r] = source.row(2 * y + r - 2);
#if RASTRO_HAS_AVX2_CODE
    if (simd_level() == SimdLevel::avx2) {
      // The vectors' tail stays inside the padded row when the padding holds at least one vector.
      if (source.padding() >= 32) {
        filter_columns_avx2(rows, count, columns.data());
      } else {
        filter_columns_plain(rows, count, columns.data());
      }
      filter_and_halve_row_avx2(columns.data(), target.width(), target.row(y));
      continue;
    }
#endif
    filter_columns_plain(rows, count, columns.data());
    filter_and_halve_row_plain(columns.data(), target.width(), target.row(y));
  }
}

}  // namespace

void halve(const PaddedImage& source, PaddedImage& target, TaskPool* pool) {
  RASTRO_CHECK(source.padding() >= 2, "the filter reads two pixels outside");
  target.reset((source.width() + 1) / 2, (source.height() + 1) / 2, source.padding());
  const auto rows = [&](int begin, int end) { halve_rows(source, target, begin, end); };
  if (pool) {
    pool->for_chunks(0, target.height(), rows_per_chunk, rows);
  } else {
    rows(0, target.height());
  }
  target.fill_padding();
}

void Pyramid::build(GrayView image, int levels, int padding, TaskPool* pool) {
  RASTRO_CHECK(levels >= 1 && !image.empty(), "a pyramid has an image and a level");
  levels_.resize(static_cast<std::size_t>(levels));
  levels_[0].reset(image.width, image.height, padding);
  for (int y = 0; y < image.height; ++y) {
    std::memcpy(levels_[0].row(y), image.row(y), static_cast<std::size_t>(image.width));
  }
  levels_[0].fill_padding();
  for (used_ = 1; used_ < levels; ++used_) {
    const PaddedImage& finer = level(used_ - 1);
    if (std::min(finer.width(), finer.height()) < 2 * smallest_side) break;
    halve(finer, levels_[static_cast<std::size_t>(used_)], pool);
  }
}

}  // namespace rastro
