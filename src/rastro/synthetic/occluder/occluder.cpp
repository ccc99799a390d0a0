// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/occluder/occluder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "rastro/base/error.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr std::int64_t earliest_pass = 8;
constexpr double shutter_share = 0.15;  // of the frame interval; gives the motion blur
// Fainter than this it is not drawn: half an intensity level at full contrast.
constexpr float least_opacity = 1.0f / 256.0f;

/// Bilinear value, 0 outside.
float sample(const Image<float>& image, double x, double y) {
  const double column = std::floor(x), line = std::floor(y);
  const auto u = static_cast<float>(x - column), v = static_cast<float>(y - line);
  const auto value = [&](double cx, double cy) {
    if (cx < 0 || cy < 0 || cx >= image.width() || cy >= image.height()) return 0.0f;
    return image.at(static_cast<int>(cx), static_cast<int>(cy));
  };
  const float above = value(column, line) * (1 - u) + value(column + 1, line) * u;
  const float below = value(column, line + 1) * (1 - u) + value(column + 1, line + 1) * u;
  return above * (1 - v) + below * v;
}

/// Weak sensor noise, so that the occluder is no cleaner than the image; -2 .. 2 intensity levels.
float grain(std::uint64_t seed, int x, int y) {
  const std::uint64_t bits = seed_for(seed, static_cast<std::uint64_t>(y) << 20 | static_cast<std::uint64_t>(x));
  return (static_cast<float>(bits & 0xFFFF) + static_cast<float>(bits >> 48)) / 32768.0f - 2.0f;
}

}  // namespace

Occluder::Occluder(int width, int height, const OccluderOptions& options)
    : width_(width), height_(height), options_(options) {
  if (width < 32 || height < 32)
    throw Error("images of " + std::to_string(width) + "x" + std::to_string(height) + " are too small for an occluder",
                "occlude", "give images of at least 32x32 pixels");
}

void Occluder::add_pass() {
  const std::uint64_t number = passes_.size();
  Random random(seed_for(options_.seed, number));
  OccluderPass pass;
  const std::int64_t free_at = passes_.empty() ? earliest_pass : passes_.back().first + passes_.back().frames + 3;
  pass.first = free_at + random.below(passes_.empty() ? 3 : 6);
  // The first two passes show both shapes; later ones are random.
  const bool figure_first = (options_.seed & 1) == 0;
  const bool figure = number < 2 ? (number == 0) == figure_first : random.uniform() < 0.5;
  pass.to_right = random.uniform() < 0.5;
  pass.occluded_frames = random.uniform(5.0, 9.0);
  pass.speed_change = random.uniform(0.05, 0.2);
  OccluderAppearance& appearance = pass.appearance;
  appearance.shape = figure ? OccluderShape::figure : OccluderShape::post;
  appearance.width_px = random.uniform(0.2, 0.3) * width_;
  appearance.height_px = height_;
  appearance.tilt_rad = random.uniform(-0.09, 0.09);
  appearance.brightness = std::clamp(options_.brightness * random.uniform(0.75, 1.25), 50.0, 190.0);
  appearance.contrast = std::clamp(options_.contrast * random.uniform(0.8, 1.2), 25.0, 60.0);
  const double speed = appearance.width_px / pass.occluded_frames;
  appearance.blur_px = shutter_share * speed;
  appearance.seed = random.next();
  const double lean = std::abs(std::tan(appearance.tilt_rad)) * height_;
  pass.frames = std::llround((width_ + appearance.width_px * 1.15 + lean) / speed) + 1;
  passes_.push_back(pass);
}

const OccluderPass& Occluder::pass_at(std::int64_t frame) {
  while (passes_.empty() || passes_.back().first + passes_.back().frames <= frame) add_pass();
  return *std::find_if(passes_.begin(), passes_.end(),
                       [&](const OccluderPass& pass) { return frame < pass.first + pass.frames; });
}

double Occluder::center_x(std::int64_t frame) {
  const OccluderPass& pass = pass_at(frame);
  const double lean = std::abs(std::tan(pass.appearance.tilt_rad)) * height_;
  const double reach = (pass.appearance.width_px * 1.15 + lean) / 2.0 + pass.appearance.blur_px + 4.0;
  const double time = std::max(0.0, static_cast<double>(frame - pass.first) / static_cast<double>(pass.frames - 1));
  constexpr double angular_frequency = 2.0 * std::numbers::pi * 2.0;
  const double progress = time + pass.speed_change * std::sin(angular_frequency * time) / angular_frequency;
  const double from = pass.to_right ? -reach : width_ - 1 + reach;
  const double to = pass.to_right ? width_ - 1 + reach : -reach;
  return from + progress * (to - from);
}

const OccluderTile& Occluder::tile_of(const OccluderPass& pass) {
  if (painted_first_ != pass.first) {
    tile_ = paint_occluder(pass.appearance);
    painted_first_ = pass.first;
  }
  return tile_;
}

void Occluder::draw(std::int64_t frame, GrayImage& image, GrayImage& mask) {
  RASTRO_CHECK(image.width() == width_ && image.height() == height_, "the image must have the size of the occluder");
  mask = GrayImage(width_, height_);
  const OccluderPass& pass = pass_at(frame);
  if (frame < pass.first) return;
  const OccluderTile& tile = tile_of(pass);
  const double left = center_x(frame) - (tile.opacity.width() - 1) / 2.0;
  // The bob of a step, for realizm.
  const double top = 0.006 * height_ * std::sin(0.9 * static_cast<double>(frame - pass.first));
  const std::uint64_t noise = seed_for(pass.appearance.seed, static_cast<std::uint64_t>(frame));
  const int begin = std::max(0, static_cast<int>(std::floor(left)));
  const int end = std::min(width_, static_cast<int>(std::ceil(left)) + tile.opacity.width() + 1);
  for (int y = 0; y < height_; ++y) {
    // Rows pushed in by the bob repeat the tile's own first or last row.
    const double tile_y = std::clamp(y - top, 0.0, tile.opacity.height() - 1.0);
    for (int x = begin; x < end; ++x) {
      const float opacity = sample(tile.opacity, x - left, tile_y);
      if (opacity < least_opacity) continue;
      const float behind = static_cast<float>(image.at(x, y)) * (1.0f - opacity);
      const float front = sample(tile.gray, x - left, tile_y) + opacity * grain(noise, x, y);
      image.at(x, y) = static_cast<std::uint8_t>(std::clamp(std::lround(behind + front), 0L, 255L));
      mask.at(x, y) = 255;
    }
  }
}

}  // namespace rastro
