// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "rastro/base/random.h"
#include "rastro/synthetic/disturbance/disturbance_parts.h"

namespace rastro::disturbance {
namespace {

constexpr std::uint64_t left_noise_seed = 71, right_noise_seed = 72, color_noise_seed = 73;

/// The measurements of the sensors; stamps and odometry stay.
struct Measurements {
  GrayImage image, right;
  ColorImage color;
  DepthImage depth;
  std::optional<LaserScan> scan;
};

void add_noise(Image<std::uint8_t>& image, double sigma, std::uint64_t seed) {
  Random random(seed);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double noisy = static_cast<double>(image.at(x, y)) + sigma * random.normal();
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(noisy, 0.0, 255.0)));
    }
  }
}

template <typename T>
void clear(Image<T>& image) {
  image = Image<T>(image.width(), image.height());
}

}  // namespace

Change none(const Value&) { return {}; }

Change black(const Value& frames) {
  return {{}, [range = frames_of(frames)](Frame& frame) {
            if (!range.holds(frame)) return true;
            clear(frame.image);
            clear(frame.right);
            clear(frame.color.rgb);
            clear(frame.depth);
            return true;
          }};
}

Change freeze(const Value& frames) {
  return {{}, [range = frames_of(frames), last = std::optional<Measurements>()](Frame& frame) mutable {
            if (range.holds(frame) && last) {
              frame.image = last->image, frame.right = last->right, frame.color = last->color;
              frame.depth = last->depth, frame.scan = last->scan;
            } else if (frame.index < range.end) {
              last = Measurements{frame.image, frame.right, frame.color, frame.depth, frame.scan};
            }
            return true;
          }};
}

Change drop(const Value& frames) {
  return {{}, [range = frames_of(frames)](Frame& frame) { return !range.holds(frame); }};
}

Change noise(const Value& sigma) {
  return {{}, [sigma = sigma.amount("a standard deviation")](Frame& frame) {
            const auto number = static_cast<std::uint64_t>(frame.index);
            add_noise(frame.image, sigma, seed_for(left_noise_seed, number));
            add_noise(frame.right, sigma, seed_for(right_noise_seed, number));
            add_noise(frame.color.rgb, sigma, seed_for(color_noise_seed, number));
            return true;
          }};
}

Change color_cast(const Value& factor) {
  return {{}, [factor = factor.factor()](Frame& frame) {
            Image<std::uint8_t>& rgb = frame.color.rgb;
            for (int y = 0; y < rgb.height(); ++y) {
              for (int x = 0; x < rgb.width(); x += 3)
                rgb.at(x, y) = static_cast<std::uint8_t>(std::lround(std::min(factor * rgb.at(x, y), 255.0)));
            }
            return true;
          }};
}

}  // namespace rastro::disturbance
