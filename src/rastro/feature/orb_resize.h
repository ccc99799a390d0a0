// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rastro/image/padded_image.h"

namespace rastro {

/// Shrinks an image by a fixed factor, bilinearly, pixel centers kept: pixel (x, y) of the result lies at ((x + 0.5) *
/// factor - 0.5, (y + 0.5) * factor - 0.5) of the source. Planned once for a size, then used for many images.
class OrbResize {
 public:
  /// The result's sides are the source's divided by the factor (1..2), rounded.
  OrbResize(int source_width, int source_height, double factor);
  int width() const { return width_; }
  int height() const { return height_; }

  /// Rows [begin, end) of `target`, whose size is width() x height(). The source's padding (at least 32) is filled.
  void run(const PaddedImage& source, PaddedImage& target, int begin, int end) const;

 private:
  /// Eight pixels of a row: where they begin in the source, and for each pixel its two source bytes and their weights.
  struct Block {
    int start = 0;
    std::array<std::uint8_t, 16> bytes{};
    std::array<std::int8_t, 16> weights{};
  };
  struct Row {
    int above = 0;            ///< Of the source; the other one is below it.
    std::int16_t weight = 0;  ///< Of the one below, times 2^15.
  };
  void shrink_row(const std::uint8_t* source, std::int16_t* out) const;
  void shrink_row_avx2(const std::uint8_t* source, std::int16_t* out) const;

  int width_, height_;
  std::vector<Block> blocks_;
  std::vector<Row> rows_;
};

}  // namespace rastro
