// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/image_shift.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "rastro/math/median.h"

namespace rastro {
namespace {

constexpr int cells_across = 80, skipped_px = 2;
constexpr float least_share = 0.5F;  // Of a cell's pixels with a depth.
constexpr std::size_t least_cells = 300;
constexpr float outlier_factor = 30.0F;  // Of the median difference: another surface, no motion.

/// The mean over each cell of what `value_of` gives for a pixel, which is below zero for none.
template <typename Pixel, typename ValueOf>
Thumbnail mean_cells(const Image<Pixel>& image, const ValueOf& value_of) {
  const int size_px = std::max(1, image.width() / cells_across);
  Thumbnail cells(image.width() / size_px, image.height() / size_px);
  for (int y = 0; y < cells.height(); ++y) {
    for (int x = 0; x < cells.width(); ++x) {
      float sum = 0.0F;
      int used = 0, all = 0;
      for (int row = 0; row < size_px; row += skipped_px) {
        const Pixel* pixels = image.row(y * size_px + row) + x * size_px;
        for (int column = 0; column < size_px; column += skipped_px, ++all) {
          const float value = value_of(pixels[column]);
          if (value < 0.0F) continue;
          sum += value;
          ++used;
        }
      }
      const bool enough = static_cast<float>(used) >= least_share * static_cast<float>(all);
      cells.at(x, y) = enough ? sum / static_cast<float>(used) : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return cells;
}

/// Binomial, over three cells in both directions.
void smooth(Thumbnail& cells) {
  const auto pass = [](float* first, int count, std::ptrdiff_t stride) {
    float before = first[0];
    for (int i = 1; i + 1 < count; ++i) {
      float& here = first[i * stride];
      const float smoothed = 0.25F * (before + first[(i + 1) * stride]) + 0.5F * here;
      before = here;
      here = smoothed;
    }
  };
  for (int y = 0; y < cells.height(); ++y) pass(cells.row(y), cells.width(), 1);
  for (int x = 0; x < cells.width() && cells.height() > 1; ++x)
    pass(cells.row(0) + x, cells.height(), cells.row(1) - cells.row(0));
}

struct Cell {
  Eigen::Vector2f gradient;
  float difference;
};

std::vector<Cell> cells_of(const Thumbnail& first, const Thumbnail& second) {
  std::vector<Cell> cells;
  const auto mean = [&](int x, int y) { return 0.5F * (first.at(x, y) + second.at(x, y)); };
  for (int y = 1; y + 1 < first.height(); ++y) {
    for (int x = 1; x + 1 < first.width(); ++x) {
      const Cell cell{0.5F * Eigen::Vector2f(mean(x + 1, y) - mean(x - 1, y), mean(x, y + 1) - mean(x, y - 1)),
                      second.at(x, y) - first.at(x, y)};
      if (cell.gradient.allFinite() && std::isfinite(cell.difference)) cells.push_back(cell);
    }
  }
  return cells;
}

}  // namespace

Thumbnail thumbnail_of(const GrayImage& image) {
  Thumbnail cells = mean_cells(image, [](std::uint8_t intensity) { return static_cast<float>(intensity); });
  for (int k = 0; k < 4; ++k) smooth(cells);
  return cells;
}

Thumbnail thumbnail_of(const DepthImage& depth) {
  return mean_cells(depth, [](float z) { return z > 0.0F ? 1.0F / z : -1.0F; });
}

Eigen::Vector2d shift_between(const Thumbnail& first, const Thumbnail& second) {
  if (first.width() != second.width() || first.height() != second.height()) return Eigen::Vector2d::Zero();
  const std::vector<Cell> cells = cells_of(first, second);
  if (cells.size() < least_cells) return Eigen::Vector2d::Zero();
  std::vector<double> sizes;
  sizes.reserve(cells.size());
  for (const Cell& cell : cells) sizes.push_back(std::abs(static_cast<double>(cell.difference)));
  const double largest = static_cast<double>(outlier_factor) * median(sizes);
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (sizes[i] > largest) continue;
    const Eigen::Vector2d gradient = cells[i].gradient.cast<double>();
    normal += gradient * gradient.transpose();
    right -= gradient * static_cast<double>(cells[i].difference);
  }
  normal.diagonal().array() += 1e-6 * normal.trace() + std::numeric_limits<double>::min();
  const Eigen::Vector2d shift = normal.ldlt().solve(right);
  return shift.allFinite() ? shift : Eigen::Vector2d::Zero();
}

}  // namespace rastro
