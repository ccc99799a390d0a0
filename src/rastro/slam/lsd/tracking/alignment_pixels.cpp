// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/alignment_pixels.h"

#include <algorithm>
#include <functional>

namespace rastro {
namespace {

constexpr int alignment_tile_px = 32;

/// Appends the pixels of a tile with sufficient gradient, row by row.
void select_tile(const PaddedImage& image, int left, int top, double least, std::vector<AlignmentPixel>& selected) {
  // The outermost pixels have no gradient across the border.
  const int x_end = std::min(left + alignment_tile_px, image.width() - 1),
            y_end = std::min(top + alignment_tile_px, image.height() - 1);
  for (int y = std::max(top, 1); y < y_end; ++y) {
    const std::uint8_t *above = image.row(y - 1), *row = image.row(y), *below = image.row(y + 1);
    for (int x = std::max(left, 1); x < x_end; ++x) {
      const AlignmentPixel pixel{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                                 static_cast<std::int16_t>(row[x + 1] - row[x - 1]),
                                 static_cast<std::int16_t>(below[x] - above[x])};
      if (pixel.strength() >= least) selected.push_back(pixel);
    }
  }
}

/// Appends the `quota` strongest of [begin, end), in their order; among equal ones the first.
void keep_strongest(const AlignmentPixel* begin, const AlignmentPixel* end, std::size_t quota,
                    std::vector<int>& strengths, std::vector<AlignmentPixel>& kept) {
  const auto count = static_cast<std::size_t>(end - begin);
  if (count <= quota) return void(kept.insert(kept.end(), begin, end));
  if (quota == 0) return;
  strengths.resize(count);
  std::transform(begin, end, strengths.begin(), [](const AlignmentPixel& pixel) { return pixel.strength(); });
  const auto weakest_kept = strengths.begin() + static_cast<std::ptrdiff_t>(quota - 1);
  std::nth_element(strengths.begin(), weakest_kept, strengths.end(), std::greater<>());
  const int limit = *weakest_kept;
  // All above the limit are kept, and of those at it as many as are still missing.
  auto missing = static_cast<std::ptrdiff_t>(quota) -
                 std::count_if(strengths.begin(), weakest_kept, [&](int strength) { return strength > limit; });
  for (const AlignmentPixel* pixel = begin; pixel < end; ++pixel) {
    const int strength = pixel->strength();
    if (strength > limit || (strength == limit && missing-- > 0)) kept.push_back(*pixel);
  }
}

/// Every tile keeps the same share, rounded so that the level has `max_points` in the end.
std::vector<AlignmentPixel> thinned_pixels(const std::vector<AlignmentPixel>& pixels,
                                           const std::vector<std::size_t>& tile_ends, std::size_t max_points) {
  std::vector<AlignmentPixel> kept;
  kept.reserve(max_points);
  std::vector<int> strengths;
  std::size_t begin = 0;
  for (const std::size_t end : tile_ends) {
    const std::size_t quota = end * max_points / pixels.size() - begin * max_points / pixels.size();
    keep_strongest(pixels.data() + begin, pixels.data() + end, quota, strengths, kept);
    begin = end;
  }
  return kept;
}

}  // namespace

AlignmentPixels::AlignmentPixels(const PaddedImage& image, double min_gradient) {
  const double least = 4.0 * min_gradient * min_gradient;
  for (int top = 0; top < image.height(); top += alignment_tile_px) {
    for (int left = 0; left < image.width(); left += alignment_tile_px) {
      select_tile(image, left, top, least, pixels_);
      tile_ends_.push_back(pixels_.size());
    }
  }
}

std::vector<AlignmentPixel> AlignmentPixels::known_ones(const InverseDepthMap& depth, std::size_t max_points) const {
  std::vector<AlignmentPixel> known(pixels_.size());
  std::vector<std::size_t> tile_ends;
  tile_ends.reserve(tile_ends_.size());
  std::size_t count = 0, next = 0;
  for (const std::size_t end : tile_ends_) {
    for (; next < end; ++next) {
      const AlignmentPixel& pixel = pixels_[next];
      known[count] = pixel;
      count += depth.is_known(pixel.x, pixel.y) ? 1 : 0;
    }
    tile_ends.push_back(count);
  }
  known.resize(count);
  return max_points == 0 || count <= max_points ? known : thinned_pixels(known, tile_ends, max_points);
}

std::vector<AlignmentPixels> alignment_pixels(const Pyramid& image, int levels, double min_gradient) {
  std::vector<AlignmentPixels> pixels;
  for (int level = 0; level < levels; ++level) pixels.emplace_back(image.level(level), min_gradient);
  return pixels;
}

}  // namespace rastro
