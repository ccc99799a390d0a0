// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/texture.h"

#include <algorithm>
#include <cmath>

namespace rastro {
namespace {

GreyImage rounded(const Image<float>& values) {
  GreyImage result(values.width(), values.height());
  for (int y = 0; y < values.height(); ++y)
    for (int x = 0; x < values.width(); ++x)
      result.at(x, y) = static_cast<std::uint8_t>(std::clamp(values.at(x, y), 0.0F, 255.0F) + 0.5F);
  return result;
}

GreyImage halved(const GreyImage& fine) {
  GreyImage coarse(std::max(1, fine.width() / 2), std::max(1, fine.height() / 2));
  const int step_x = fine.width() > 1 ? 1 : 0;
  for (int y = 0; y < coarse.height(); ++y) {
    const std::uint8_t* upper = fine.row(fine.height() > 1 ? 2 * y : 0);
    const std::uint8_t* lower = fine.row(fine.height() > 1 ? 2 * y + 1 : 0);
    for (int x = 0; x < coarse.width(); ++x) {
      const int left = (1 + step_x) * x, right = left + step_x;
      coarse.at(x, y) = static_cast<std::uint8_t>((upper[left] + upper[right] + lower[left] + lower[right] + 2) >> 2);
    }
  }
  return coarse;
}

float bilinear(const GreyImage& image, float x, float y) {
  x = std::clamp(x - 0.5F, 0.0F, static_cast<float>(image.width() - 1));
  y = std::clamp(y - 0.5F, 0.0F, static_cast<float>(image.height() - 1));
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
  const int right = std::min(left + 1, image.width() - 1);
  const std::uint8_t* upper = image.row(top);
  const std::uint8_t* lower = image.row(std::min(top + 1, image.height() - 1));
  const float above = static_cast<float>(upper[left]) + u * static_cast<float>(upper[right] - upper[left]);
  const float below = static_cast<float>(lower[left]) + u * static_cast<float>(lower[right] - lower[left]);
  return above + v * (below - above);
}

}  // namespace

Texture::Texture(const Image<float>& values) {
  levels_.push_back(rounded(values));
  while (levels_.back().width() > 1 || levels_.back().height() > 1) levels_.push_back(halved(levels_.back()));
}

std::size_t Texture::bytes() const {
  std::size_t total = 0;
  for (const GreyImage& level : levels_)
    total += static_cast<std::size_t>(level.stride()) * static_cast<std::size_t>(level.height());
  return total;
}

float Texture::trilinear(float x, float y, float level) const {
  const int finer = std::min(static_cast<int>(level), static_cast<int>(levels_.size()) - 1);
  // Odd sizes are cut when halved: scale by the true ratio of the sizes, else far levels would drift by many texels.
  const auto at = [&](int index) {
    const GreyImage& image = levels_[static_cast<std::size_t>(index)];
    const float scale_x = static_cast<float>(image.width()) / static_cast<float>(levels_[0].width());
    const float scale_y = static_cast<float>(image.height()) / static_cast<float>(levels_[0].height());
    return bilinear(image, x * scale_x, y * scale_y);
  };
  const float value = at(finer);
  const float fraction = level - static_cast<float>(finer);
  if (fraction <= 0.0F || finer + 1 >= static_cast<int>(levels_.size())) return value;
  return value + fraction * (at(finer + 1) - value);
}

float Texture::sample(float x, float y, float dx_dx, float dy_dx, float dx_dy, float dy_dy) const {
  constexpr float most_probes = 6.0F;
  float major_x = dx_dx, major_y = dy_dx;
  float major = std::sqrt(dx_dx * dx_dx + dy_dx * dy_dx), minor = std::sqrt(dx_dy * dx_dy + dy_dy * dy_dy);
  if (minor > major) {
    std::swap(major, minor);
    major_x = dx_dy, major_y = dy_dy;
  }
  minor = std::max({minor, major / most_probes, 1e-6F});
  const int probes = std::max(1, static_cast<int>(std::ceil(major / std::max(minor, 1.0F) - 0.25F)));
  const float level = std::max(0.0F, std::log2(minor));
  if (probes == 1) return trilinear(x, y, level);
  float sum = 0.0F;
  for (int probe = 0; probe < probes; ++probe) {
    const float offset = (static_cast<float>(probe) + 0.5F) / static_cast<float>(probes) - 0.5F;
    sum += trilinear(x + offset * major_x, y + offset * major_y, level);
  }
  return sum / static_cast<float>(probes);
}

}  // namespace rastro
