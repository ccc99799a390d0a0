// SPDX-License-Identifier: Apache-2.0
#include "rastro/feature/corner.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "rastro/base/simd.h"
#include "rastro/feature/distance_grid.h"
#include "rastro/feature/min_eigenvalue.h"

#if RASTRO_HAS_AVX2_CODE
#include <immintrin.h>
#endif

namespace rastro {
namespace {

constexpr int tile_width = 32;
constexpr int tile_height = 16;

struct Area {
  int x0, x1, y0, y1;
};

/// The local maxima of one band of tiles, and the best score found so far, in any band.
struct Band {
  std::vector<Corner> maxima;
  float best = 0.0F;
};

/// The best score of all bands so far. Its value at a given time depends on the threads, but it only ever excludes
/// maxima that the final threshold excludes as well.
class SharedBest {
 public:
  float get() const { return best_.load(std::memory_order_relaxed); }
  void raise(float score) {
    float seen = get();
    while (seen < score && !best_.compare_exchange_weak(seen, score, std::memory_order_relaxed)) {
    }
  }

 private:
  std::atomic<float> best_ = 0.0F;
};

struct BandBuffers {
  MinEigenvalueScratch gradients;
  Image<float> scores;
  std::vector<int> maxima;
};

/// Which tiles of a band have a free pixel.
std::vector<char> free_tiles(GrayView free, const Area& band) {
  std::vector<char> tiles(static_cast<std::size_t>((band.x1 - band.x0 + tile_width - 1) / tile_width));
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    const int x0 = band.x0 + static_cast<int>(tile) * tile_width;
    const auto length = static_cast<std::size_t>(std::min(tile_width, band.x1 - x0));
    for (int y = band.y0; y < band.y1 && tiles[tile] == 0; ++y) {
      std::uint64_t words[tile_width / 8] = {};
      std::memcpy(words, free.row(y) + x0, length);
      if ((words[0] | words[1] | words[2] | words[3]) != 0) tiles[tile] = 1;
    }
  }
  return tiles;
}

bool is_local_maximum(const float* above, const float* here, const float* below, int x) {
  const float score = here[x];
  return score > here[x - 1] && score >= here[x + 1] && score > above[x - 1] && score > above[x] &&
         score > above[x + 1] && score >= below[x - 1] && score >= below[x] && score >= below[x + 1];
}

/// The rows of scores around one row of the image, so that here[x] is the score of pixel x.
struct ScoreRows {
  const float *above, *here, *below;
  const std::uint8_t* free;
};

void row_maxima_plain(const ScoreRows& rows, int begin, int end, float floor, std::vector<int>& maxima) {
  for (int x = begin; x < end; ++x) {
    if (rows.here[x] > floor && rows.free[x] != 0 && is_local_maximum(rows.above, rows.here, rows.below, x))
      maxima.push_back(x);
  }
}

#if RASTRO_HAS_AVX2_CODE
RASTRO_TARGET_AVX2 inline __m256 beats(__m256 here, const float* there) {
  return _mm256_cmp_ps(here, _mm256_loadu_ps(there), _CMP_GT_OQ);
}
RASTRO_TARGET_AVX2 inline __m256 holds(__m256 here, const float* there) {
  return _mm256_cmp_ps(here, _mm256_loadu_ps(there), _CMP_GE_OQ);
}
RASTRO_TARGET_AVX2 inline __m256 all_of(__m256 a, __m256 b, __m256 c) { return _mm256_and_ps(a, _mm256_and_ps(b, c)); }

RASTRO_TARGET_AVX2 void row_maxima_avx2(const ScoreRows& rows, int begin, int end, float floor,
                                        std::vector<int>& maxima) {
  const __m256 floors = _mm256_set1_ps(floor);
  int x = begin;
  for (; x + 8 <= end; x += 8) {
    const __m256 here = _mm256_loadu_ps(rows.here + x);
    const __m256 high =
        all_of(_mm256_cmp_ps(here, floors, _CMP_GT_OQ), beats(here, rows.here + x - 1), holds(here, rows.here + x + 1));
    if (_mm256_testz_ps(high, high) != 0) continue;
    const __m256 over =
        all_of(beats(here, rows.above + x - 1), beats(here, rows.above + x), beats(here, rows.above + x + 1));
    const __m256 under =
        all_of(holds(here, rows.below + x - 1), holds(here, rows.below + x), holds(here, rows.below + x + 1));
    auto peaks = static_cast<unsigned>(_mm256_movemask_ps(_mm256_and_ps(high, _mm256_and_ps(over, under))));
    for (; peaks != 0; peaks &= peaks - 1) {
      const int peak = x + std::countr_zero(peaks);
      if (rows.free[peak] != 0) maxima.push_back(peak);
    }
  }
  row_maxima_plain(rows, x, end, floor, maxima);
}
#endif

/// The free local maxima of a row above the floor, from left to right.
void row_maxima(const ScoreRows& rows, int begin, int end, float floor, std::vector<int>& maxima) {
  maxima.clear();
#if RASTRO_HAS_AVX2_CODE
  if (simd_level() == SimdLevel::avx2) {
    row_maxima_avx2(rows, begin, end, floor, maxima);
    return;
  }
#endif
  row_maxima_plain(rows, begin, end, floor, maxima);
}

/// Adds the free local maxima of `area` to the band. Scores below `quality` times the best so far cannot survive the
/// final threshold, so dropping them early changes nothing.
void collect_maxima(const PaddedImage& image, GrayView free, const Area& area, double quality, BandBuffers& buffers,
                    Band& band) {
  min_eigenvalues(image, area.x0 - 1, area.x1 + 1, area.y0 - 1, area.y1 + 1, buffers.scores.row(0),
                  buffers.scores.stride(), buffers.gradients);
  for (int y = area.y0; y < area.y1; ++y) {
    const float* here = buffers.scores.row(y - area.y0 + 1) + 1 - area.x0;
    const ScoreRows rows{here - buffers.scores.stride(), here, here + buffers.scores.stride(), free.row(y)};
    row_maxima(rows, area.x0, area.x1, static_cast<float>(quality) * band.best, buffers.maxima);
    for (const int x : buffers.maxima) {
      band.maxima.push_back({x, y, here[x]});
      band.best = std::max(band.best, here[x]);
    }
  }
}

void search_band(const PaddedImage& image, GrayView free, const Area& inside, int band_index, double quality,
                 SharedBest& shared, Band& band) {
  // One set of buffers per thread: their contents never outlive a call.
  thread_local BandBuffers buffers;
  if (buffers.scores.width() < image.width() + 64) buffers.scores = Image<float>(image.width() + 64, tile_height + 2);
  band.maxima.clear();
  band.best = shared.get();
  Area area{0, 0, inside.y0 + band_index * tile_height,
            std::min(inside.y1, inside.y0 + (band_index + 1) * tile_height)};
  const std::vector<char> tiles = free_tiles(free, {inside.x0, inside.x1, area.y0, area.y1});
  for (std::size_t tile = 0; tile < tiles.size();) {
    // Adjacent free tiles are processed together, which saves their common margins.
    std::size_t end = tile;
    while (end < tiles.size() && tiles[end] != 0) ++end;
    if (end > tile) {
      area.x0 = inside.x0 + static_cast<int>(tile) * tile_width;
      area.x1 = std::min(inside.x1, inside.x0 + static_cast<int>(end) * tile_width);
      collect_maxima(image, free, area, quality, buffers, band);
    }
    tile = std::max(end, tile + 1);
  }
  shared.raise(band.best);
}

bool stronger(const Corner& a, const Corner& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

/// Greedy selection, strongest first. Sorts in growing portions, since usually only a small part is used.
std::vector<Corner> choose(std::vector<Corner>& candidates, int count, double min_distance, int width, int height) {
  std::vector<Corner> chosen;
  DistanceGrid grid(width, height, min_distance);
  auto sorted_end = candidates.begin();
  std::ptrdiff_t portion = std::max(64, 2 * count);
  for (auto next = candidates.begin(); next != candidates.end() && static_cast<int>(chosen.size()) < count; ++next) {
    if (next == sorted_end) {
      sorted_end += std::min(portion, candidates.end() - sorted_end);
      if (sorted_end != candidates.end()) std::nth_element(next, sorted_end, candidates.end(), stronger);
      std::sort(next, sorted_end, stronger);
      portion *= 2;
    }
    if (grid.add_if_far(static_cast<float>(next->x), static_cast<float>(next->y))) chosen.push_back(*next);
  }
  return chosen;
}

}  // namespace

struct CornerDetector::Buffers {
  std::vector<Band> bands;
  std::vector<Corner> candidates;
};

CornerDetector::CornerDetector() : buffers_(std::make_unique<Buffers>()) {}
CornerDetector::~CornerDetector() = default;

std::vector<Corner> CornerDetector::detect(const PaddedImage& image, GrayView free, int count,
                                           const CornerOptions& options, TaskPool* pool) {
  RASTRO_CHECK(free.width == image.width() && free.height == image.height(),
               "the free mask must have the image's size");
  candidates_ = 0;
  const int border = std::max(options.border_px, 0);
  const Area inside{border, image.width() - border, border, image.height() - border};
  if (count <= 0 || inside.x0 >= inside.x1 || inside.y0 >= inside.y1) return {};

  auto& bands = buffers_->bands;
  bands.resize(static_cast<std::size_t>((inside.y1 - inside.y0 + tile_height - 1) / tile_height));
  SharedBest shared;
  const auto search = [&](int begin, int end) {
    for (int b = begin; b < end; ++b) {
      search_band(image, free, inside, b, options.quality, shared, bands[static_cast<std::size_t>(b)]);
    }
  };
  if (pool) {
    pool->for_chunks(0, static_cast<int>(bands.size()), 2, search);
  } else {
    search(0, static_cast<int>(bands.size()));
  }

  const float floor = static_cast<float>(options.quality) * shared.get();
  std::vector<Corner>& candidates = buffers_->candidates;
  candidates.clear();
  for (const Band& band : bands) {
    std::copy_if(band.maxima.begin(), band.maxima.end(), std::back_inserter(candidates),
                 [floor](const Corner& corner) { return corner.score > floor; });
  }
  candidates_ = static_cast<int>(candidates.size());
  return choose(candidates, count, options.min_distance_px, image.width(), image.height());
}

}  // namespace rastro
