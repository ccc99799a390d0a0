// SPDX-License-Identifier: Apache-2.0
// Feeds a moving pattern to the installed tracker and ends with 0 only when the features moved as the pattern did.
#include <cstdint>
#include <cstdio>
#include <map>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/image/image.h"
#include "rastro/track/tracker.h"

namespace {

constexpr int width = 320;
constexpr int height = 240;

/// Random blocks of 12 px, shifted by `shift` px to the right.
rastro::GrayImage pattern(int shift) {
  rastro::GrayImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto block = static_cast<std::uint64_t>((y / 12) * 1000 + (x - shift + 1200) / 12);
      image.at(x, y) = static_cast<std::uint8_t>(rastro::seed_for(1, block) % 200 + 20);
    }
  }
  return image;
}

}  // namespace

int main() try {
  rastro::TrackOptions options;
  options.features = 60;
  options.min_distance_px = 10.0;
  rastro::Tracker tracker(options);
  std::map<std::int64_t, float> last_x;
  int followed = 0;
  int wrong = 0;
  for (int i = 0; i < 5; ++i) {
    const rastro::GrayImage image = pattern(2 * i);
    const rastro::TrackFrame frame = tracker.process(image, i * rastro::ns_per_second / 20);
    for (const rastro::TrackedFeature& feature : frame.features) {
      const auto before = last_x.find(feature.id);
      if (before != last_x.end() && feature.state == rastro::TrackState::tracked) {
        const float moved = feature.pixel.x() - before->second;
        ++(moved > 1.5F && moved < 2.5F ? followed : wrong);
      }
      last_x[feature.id] = feature.pixel.x();
    }
  }
  std::printf("consumer: %d steps followed, %d wrong\n", followed, wrong);
  return followed > 100 && wrong * 20 < followed ? 0 : 1;
} catch (const rastro::Error& error) {
  std::fprintf(stderr, "consumer: %s\n", error.what());
  return 2;
}
