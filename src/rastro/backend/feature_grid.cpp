// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/feature_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace rastro {
namespace {

constexpr float cell_px = 16.0F;

int cell_of(float value, float least, int count) {
  return std::clamp(static_cast<int>(std::floor((value - least) / cell_px)), 0, count - 1);
}

}  // namespace

FeatureGrid::FeatureGrid(const Camera& camera, std::shared_ptr<const Features> features,
                         std::vector<Eigen::Vector2f> pixels, std::vector<float> right_pixels)
    : features_(std::move(features)), pixels_(std::move(pixels)), right_(std::move(right_pixels)) {
  find_bounds(camera);
  fill_cells();
}

void FeatureGrid::find_bounds(const Camera& camera) {
  min_x_ = min_y_ = std::numeric_limits<float>::max();
  max_x_ = max_y_ = std::numeric_limits<float>::lowest();
  const auto include = [&](float x, float y) {
    min_x_ = std::min(min_x_, x);
    max_x_ = std::max(max_x_, x);
    min_y_ = std::min(min_y_, y);
    max_y_ = std::max(max_y_, y);
  };
  for (const Eigen::Vector2f& pixel : pixels_) {
    if (pixel.allFinite()) include(pixel.x(), pixel.y());
  }
  if (camera.distortion == Distortion::none && camera.width > 0) {
    include(0.0F, 0.0F);
    include(static_cast<float>(camera.width), static_cast<float>(camera.height));
  }
  if (max_x_ < min_x_) min_x_ = min_y_ = max_x_ = max_y_ = 0.0F;
  max_x_ += 1.0F;
  max_y_ += 1.0F;
  columns_ = std::clamp(static_cast<int>((max_x_ - min_x_) / cell_px) + 1, 1, 1000);
  rows_ = std::clamp(static_cast<int>((max_y_ - min_y_) / cell_px) + 1, 1, 1000);
}

void FeatureGrid::fill_cells() {
  std::vector<std::uint32_t> cells(pixels_.size());
  cell_begin_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (!pixels_[i].allFinite()) continue;
    cells[i] = static_cast<std::uint32_t>(cell_of(pixels_[i].y(), min_y_, rows_) * columns_ +
                                          cell_of(pixels_[i].x(), min_x_, columns_));
    ++cell_begin_[cells[i] + 1];
  }
  for (std::size_t c = 1; c < cell_begin_.size(); ++c) cell_begin_[c] += cell_begin_[c - 1];
  cell_features_.resize(cell_begin_.back());
  std::vector<std::uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    if (pixels_[i].allFinite()) cell_features_[next[cells[i]]++] = static_cast<std::uint32_t>(i);
  }
}

void FeatureGrid::find(float x, float y, float radius, int min_level, int max_level,
                       std::vector<std::uint32_t>& found) const {
  found.clear();
  if (!(x + radius >= min_x_ && x - radius < max_x_ && y + radius >= min_y_ && y - radius < max_y_)) return;
  const int left = cell_of(x - radius, min_x_, columns_), right = cell_of(x + radius, min_x_, columns_);
  const int top = cell_of(y - radius, min_y_, rows_), bottom = cell_of(y + radius, min_y_, rows_);
  const std::vector<std::uint8_t>& levels = features_->levels;
  for (int row = top; row <= bottom; ++row) {
    // The cells of a row are contiguous.
    const std::uint32_t begin = cell_begin_[static_cast<std::size_t>(row * columns_ + left)];
    const std::uint32_t end = cell_begin_[static_cast<std::size_t>(row * columns_ + right) + 1];
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t i = cell_features_[k];
      const int level = levels[i];
      if (level < min_level || level > max_level) continue;
      if (std::abs(pixels_[i].x() - x) <= radius && std::abs(pixels_[i].y() - y) <= radius) found.push_back(i);
    }
  }
}

}  // namespace rastro
