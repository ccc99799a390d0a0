// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/synthetic/disturbance/disturbance_parts.h"

namespace rastro::disturbance {
namespace {

using Pixels = Image<std::uint8_t>;

constexpr std::uint64_t left_seed = 81, right_seed = 82, color_seed = 83, crowd_seed = 84;

/// Changes every image of a frame: function(image, channels, seed of its noise).
template <typename Function>
void for_each_image(Frame& frame, const Function& change) {
  const auto number = static_cast<std::uint64_t>(frame.index);
  change(frame.image, 1, seed_for(left_seed, number));
  change(frame.right, 1, seed_for(right_seed, number));
  change(frame.color.rgb, 3, seed_for(color_seed, number));
}

/// Light that came in while the camera turned about its vertical axis: the mean over `length` pixels of a row.
void blur_rows(Pixels& image, int channels, int length) {
  const int width = image.width() / channels;
  std::vector<std::uint8_t> row(static_cast<std::size_t>(image.width()));
  for (int y = 0; y < image.height(); ++y) {
    std::copy_n(image.row(y), image.width(), row.begin());
    for (int x = 0; x < image.width(); ++x) {
      int sum = length / 2;
      for (int k = 0; k < length; ++k) {
        const int from = std::clamp(x / channels + k - length / 2, 0, width - 1);
        sum += row[static_cast<std::size_t>(channels * from + x % channels)];
      }
      image.at(x, y) = static_cast<std::uint8_t>(sum / length);
    }
  }
}

/// Less light and the noise of the electronics, which stays.
void darken(Pixels& image, double factor, std::uint64_t seed) {
  constexpr double read_noise = 1.5;
  Random random(seed);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double dark = image.at(x, y) / factor + read_noise * random.normal();
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(dark, 0.0, 255.0)));
    }
  }
}

/// Figures that walk through the image, as tall as it is. Units: widths and heights of the image.
struct Walker {
  double start = 0.0, speed_per_frame = 0.0, width = 0.0;
  std::uint64_t texture = 0;

  /// Left edge in frame k; it enters again where it left.
  double left(std::int64_t k) const {
    const double way = 1.0 + width;
    const double at = std::fmod(start + speed_per_frame * static_cast<double>(k), way);
    return (at < 0.0 ? at + way : at) - width;
  }
};

std::vector<Walker> walkers(double share) {
  constexpr int count = 4;
  constexpr double fastest = 0.02;  // of the width of the image per frame: across it in under two seconds
  Random random(crowd_seed);
  std::vector<Walker> all;
  for (int k = 0; k < count; ++k) {
    const double speed = (0.25 + 0.75 * random.uniform()) * fastest;
    // Where one spends part of its time outside, it is wider, so that the share holds on average.
    const double width = share / count / std::max(0.05, 1.0 - share / count);
    all.push_back({random.uniform() * (1.0 + width), k % 2 == 0 ? speed : -speed, width,
                   seed_for(crowd_seed, static_cast<std::uint64_t>(k))});
  }
  return all;
}

/// The intensity of a walker at a point of it, in squares of `block` pixels.
std::uint8_t texture_of(const Walker& walker, int x, int y, int block) {
  const auto square = static_cast<std::uint64_t>(y / block * 4096 + x / block);
  return static_cast<std::uint8_t>(40 + seed_for(walker.texture, square) % 176);
}

void draw(const Walker& walker, std::int64_t frame, Pixels& image, int channels) {
  if (image.empty()) return;
  const int width = image.width() / channels, block = std::max(2, image.height() / 40);
  const int left = static_cast<int>(std::lround(walker.left(frame) * width));
  const int right = left + static_cast<int>(std::lround(walker.width * width));
  for (int y = 0; y < image.height(); ++y)
    for (int x = std::max(0, left); x < std::min(width, right); ++x)
      for (int c = 0; c < channels; ++c) image.at(channels * x + c, y) = texture_of(walker, x - left, y, block);
}

void draw_depth(const Walker& walker, std::int64_t frame, DepthImage& depth) {
  constexpr float distance_m = 1.0F;
  const int left = static_cast<int>(std::lround(walker.left(frame) * depth.width()));
  const int right = left + static_cast<int>(std::lround(walker.width * depth.width()));
  for (int y = 0; y < depth.height(); ++y)
    for (int x = std::max(0, left); x < std::min(depth.width(), right); ++x) depth.at(x, y) = distance_m;
}

}  // namespace

Change blur(const Value& pixels) {
  const int length = std::max(1, static_cast<int>(std::min<std::int64_t>(pixels.count(), 512)));
  return {{}, [length](Frame& frame) {
            for_each_image(frame,
                           [&](Pixels& image, int channels, std::uint64_t) { blur_rows(image, channels, length); });
            return true;
          }};
}

Change dark(const Value& factor) {
  return {{}, [factor = factor.factor()](Frame& frame) {
            for_each_image(frame, [&](Pixels& image, int, std::uint64_t seed) { darken(image, factor, seed); });
            return true;
          }};
}

Change crowd(const Value& share) {
  return {{}, [all = walkers(std::min(share.amount("a share of the image"), 0.9))](Frame& frame) {
            for (const Walker& walker : all) {
              for_each_image(frame, [&](Pixels& image, int channels, std::uint64_t) {
                draw(walker, frame.index, image, channels);
              });
              draw_depth(walker, frame.index, frame.depth);
            }
            return true;
          }};
}

}  // namespace rastro::disturbance
