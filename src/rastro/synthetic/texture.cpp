// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/texture.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cmath>

namespace rastro {
namespace {

GrayImage rounded(const Image<float>& values) {
  GrayImage result(values.width(), values.height());
  for (int y = 0; y < values.height(); ++y)
    for (int x = 0; x < values.width(); ++x)
      result.at(x, y) = static_cast<std::uint8_t>(std::clamp(values.at(x, y), 0.0F, 255.0F) + 0.5F);
  return result;
}

GrayImage halved(const GrayImage& fine) {
  GrayImage coarse(std::max(1, fine.width() / 2), std::max(1, fine.height() / 2));
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

float bilinear(const GrayImage& image, float x, float y) {
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

using Channels = Eigen::Array4f;

Channels unpacked(std::uint32_t texel) {
#ifdef __SSE2__
  const __m128i zero = _mm_setzero_si128();
  const __m128i words = _mm_unpacklo_epi8(_mm_cvtsi32_si128(static_cast<int>(texel)), zero);
  Channels channels;
  _mm_store_ps(channels.data(), _mm_cvtepi32_ps(_mm_unpacklo_epi16(words, zero)));
  return channels;
#else
  return Eigen::Array4i(static_cast<int>(texel & 255U), static_cast<int>(texel >> 8 & 255U),
                        static_cast<int>(texel >> 16 & 255U), 0)
      .cast<float>();
#endif
}

std::uint32_t packed(const Channels& channels) {
  const Eigen::Array4i whole = (channels.max(0.0F).min(255.0F) + 0.5F).cast<int>();
  return static_cast<std::uint32_t>(whole[0] | whole[1] << 8 | whole[2] << 16);
}

Image<std::uint32_t> halved(const Image<std::uint32_t>& fine) {
  Image<std::uint32_t> coarse(std::max(1, fine.width() / 2), std::max(1, fine.height() / 2));
  const int step_x = fine.width() > 1 ? 1 : 0, step_y = fine.height() > 1 ? 1 : 0;
  for (int y = 0; y < coarse.height(); ++y)
    for (int x = 0; x < coarse.width(); ++x) {
      const int left = (1 + step_x) * x, top = (1 + step_y) * y;
      coarse.at(x, y) =
          packed(0.25F * (unpacked(fine.at(left, top)) + unpacked(fine.at(left + step_x, top)) +
                          unpacked(fine.at(left, top + step_y)) + unpacked(fine.at(left + step_x, top + step_y))));
    }
  return coarse;
}

Channels bilinear(const Image<std::uint32_t>& image, float x, float y) {
  x = std::clamp(x - 0.5F, 0.0F, static_cast<float>(image.width() - 1));
  y = std::clamp(y - 0.5F, 0.0F, static_cast<float>(image.height() - 1));
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
  const int right = std::min(left + 1, image.width() - 1);
  const std::uint32_t* upper = image.row(top);
  const std::uint32_t* lower = image.row(std::min(top + 1, image.height() - 1));
  const Channels upper_left = unpacked(upper[left]), lower_left = unpacked(lower[left]);
  const Channels above = upper_left + u * (unpacked(upper[right]) - upper_left);
  const Channels below = lower_left + u * (unpacked(lower[right]) - lower_left);
  return above + v * (below - above);
}

/// log2 of a number >= 1, exact at powers of two and at most 0.09 too small between them.
float quick_log2(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  return exponent + static_cast<float>(bits & 0x7FFFFFU) * 0x1.0p-23F;
}

}  // namespace

Texture::Texture(const Image<float>& values) {
  levels_.push_back(rounded(values));
  while (levels_.back().width() > 1 || levels_.back().height() > 1) levels_.push_back(halved(levels_.back()));
}

std::size_t Texture::bytes() const {
  std::size_t total = 0;
  for (const GrayImage& level : levels_)
    total += static_cast<std::size_t>(level.stride()) * static_cast<std::size_t>(level.height());
  return total;
}

float Texture::trilinear(float x, float y, float level) const {
  const int finer = std::min(static_cast<int>(level), static_cast<int>(levels_.size()) - 1);
  // Odd sizes are truncated when halved: scale by the true ratio of the sizes, else coarse levels would drift by many
  // texels.
  const auto at = [&](int index) {
    const GrayImage& image = levels_[static_cast<std::size_t>(index)];
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

ColorTexture::ColorTexture(const Image<float>& values, const Image<std::uint8_t>& ink_of, std::span<const Tint> inks) {
  Image<std::uint32_t> finest(values.width(), values.height());
  for (int y = 0; y < values.height(); ++y)
    for (int x = 0; x < values.width(); ++x) {
      const Tint& tint = inks[ink_of.empty() ? 0 : ink_of.at(x, y)];
      finest.at(x, y) = packed(values.at(x, y) * Channels(tint.red, tint.green, tint.blue, 0.0F));
    }
  levels_.push_back({std::move(finest)});
  while (levels_.back().texels.width() > 1 || levels_.back().texels.height() > 1)
    levels_.push_back({halved(levels_.back().texels)});
  for (Level& level : levels_) {
    level.scale_x = static_cast<float>(level.texels.width()) / static_cast<float>(values.width());
    level.scale_y = static_cast<float>(level.texels.height()) / static_cast<float>(values.height());
  }
}

std::size_t ColorTexture::bytes() const {
  std::size_t total = 0;
  for (const Level& level : levels_)
    total += sizeof(std::uint32_t) * static_cast<std::size_t>(level.texels.stride() * level.texels.height());
  return total;
}

Eigen::Array4f ColorTexture::mean() const { return unpacked(levels_.back().texels.at(0, 0)); }

Eigen::Array4f ColorTexture::trilinear(float x, float y, float level) const {
  const int finer = std::min(static_cast<int>(level), static_cast<int>(levels_.size()) - 1);
  const auto at = [&](int index) {
    const Level& shown = levels_[static_cast<std::size_t>(index)];
    return bilinear(shown.texels, x * shown.scale_x, y * shown.scale_y);
  };
  const Channels value = at(finer);
  const float fraction = level - static_cast<float>(finer);
  if (fraction <= 0.0F || finer + 1 >= static_cast<int>(levels_.size())) return value;
  return value + fraction * (at(finer + 1) - value);
}

Eigen::Array4f ColorTexture::sample(float x, float y, float dx_dx, float dy_dx, float dx_dy, float dy_dy) const {
  constexpr float most_probes = 4.0F;
  float major_x = dx_dx, major_y = dy_dx;
  float major = std::sqrt(dx_dx * dx_dx + dy_dx * dy_dx), minor = std::sqrt(dx_dy * dx_dy + dy_dy * dy_dy);
  if (minor > major) {
    std::swap(major, minor);
    major_x = dx_dy, major_y = dy_dy;
  }
  minor = std::max({minor, major / most_probes, 1.0F});
  const int probes = std::max(1, static_cast<int>(std::ceil(major / minor - 0.25F)));
  const float level = quick_log2(minor);
  if (probes == 1) return trilinear(x, y, level);
  Channels sum = Channels::Zero();
  for (int probe = 0; probe < probes; ++probe) {
    const float offset = (static_cast<float>(probe) + 0.5F) / static_cast<float>(probes) - 0.5F;
    sum += trilinear(x + offset * major_x, y + offset * major_y, level);
  }
  return sum / static_cast<float>(probes);
}

}  // namespace rastro
