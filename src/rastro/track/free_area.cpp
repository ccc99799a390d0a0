// SPDX-License-Identifier: Apache-2.0
#include "rastro/track/free_area.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace rastro {

void FreeArea::reset(int width, int height, GrayView mask) {
  if (area_.width() != width || area_.height() != height) area_ = GrayImage(width, height);
  for (int y = 0; y < height; ++y) {
    if (mask.empty()) {
      std::memset(area_.row(y), 255, static_cast<std::size_t>(width));
    } else {
      std::memcpy(area_.row(y), mask.row(y), static_cast<std::size_t>(width));
    }
  }
}

void FreeArea::block(const Eigen::Vector2f& center, double radius) {
  if (radius != radius_) {
    radius_ = radius;
    half_widths_.clear();
    // A pixel at exactly the distance is free.
    for (int dy = 0; dy < radius; ++dy)
      half_widths_.push_back(static_cast<int>(std::ceil(std::sqrt(radius * radius - dy * dy))) - 1);
  }
  const int cx = static_cast<int>(std::lround(center.x())), cy = static_cast<int>(std::lround(center.y()));
  const int reach = static_cast<int>(half_widths_.size()) - 1;
  for (int y = std::max(0, cy - reach); y <= std::min(area_.height() - 1, cy + reach); ++y) {
    const int half = half_widths_[static_cast<std::size_t>(std::abs(y - cy))];
    const int x0 = std::max(0, cx - half), x1 = std::min(area_.width() - 1, cx + half);
    if (x0 <= x1) std::memset(area_.row(y) + x0, 0, static_cast<std::size_t>(x1 - x0 + 1));
  }
}

}  // namespace rastro
