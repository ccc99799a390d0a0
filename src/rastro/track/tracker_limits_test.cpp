// SPDX-License-Identifier: Apache-2.0
// At which share of lost features the tracker changes what it does, and where features may be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/image/image_testing.h"
#include "rastro/track/tracker.h"

namespace rastro {
namespace {

constexpr int image_px = 240;

/// A window into waves.
GrayImage waves_at(int left, int top) { return testing::wave_image(image_px, image_px, -left, -top); }

TrackOptions small_options(const char* mode) {
  TrackOptions options;
  options.mode = mode;
  options.min_distance_px = 15;
  options.brief_patch_px = 32;
  options.brief_smoothing_px = 5;
  return options;
}

GrayImage open_mask() {
  GrayImage mask(image_px, image_px);
  for (int y = 0; y < image_px; ++y) std::fill_n(mask.row(y), image_px, std::uint8_t{255});
  return mask;
}

/// The same image twice; in the second frame a mask hides all but the first features.
struct HiddenBehindMask {
  explicit HiddenBehindMask(int features, int kept) {
    TrackOptions options = small_options("klt");
    options.features = features;
    Tracker tracker(options);
    const GrayImage image = waves_at(0, 0);
    first = tracker.process(image.view(), 0);
    GrayImage mask = open_mask();
    for (std::size_t i = static_cast<std::size_t>(kept); i < first.features.size(); ++i) {
      const Eigen::Vector2i at = first.features[i].pixel.array().round().cast<int>();
      for (int y = at.y() - 1; y <= at.y() + 1; ++y) std::fill_n(mask.row(y) + at.x() - 1, 3, std::uint8_t{0});
    }
    second = tracker.process(image.view(), 1, mask.view());
  }
  TrackFrame first, second;
};

TEST(TrackerLimits, LessThanAQuarterOfTheFeaturesIsAnAbruptMotion) {
  for (const int kept : {9, 10, 11}) {
    const HiddenBehindMask hidden(40, kept);
    ASSERT_EQ(hidden.first.features.size(), 40U);
    ASSERT_EQ(hidden.second.tracked, kept);
    EXPECT_EQ(hidden.second.health == TrackHealth::abrupt_motion, kept < 10) << kept;
  }
}

TEST(TrackerLimits, FeaturesBeginWhereOthersWereLostOnlyIfMostAre) {
  for (const int kept : {19, 20, 21}) {
    const HiddenBehindMask hidden(40, kept);
    ASSERT_EQ(hidden.second.tracked, kept);
    int near_a_loss = 0;
    for (const TrackedFeature& fresh : hidden.second.features) {
      if (fresh.state != TrackState::fresh) continue;
      near_a_loss += std::any_of(hidden.first.features.begin() + kept, hidden.first.features.end(),
                                 [&](const TrackedFeature& lost) { return (lost.pixel - fresh.pixel).norm() < 15.0F; });
    }
    EXPECT_EQ(near_a_loss > 0, kept < 20) << near_a_loss;
  }
}

TEST(TrackerLimits, AFrameOrMaskThatDiffersInOneDimensionAloneIsRefused) {
  Tracker tracker(small_options("klt"));
  const GrayImage image = waves_at(0, 0);
  tracker.process(image.view(), 0);
  for (const auto& [width, height] : {std::pair{image_px - 1, image_px}, {image_px, image_px - 1}}) {
    const GrayImage other(width, height);
    EXPECT_THROW(tracker.process(other.view(), 1), Error) << width;
    EXPECT_THROW(tracker.process(image.view(), 1, other.view()), Error) << width;
  }
}

/// The image moves by 3 px in each frame toward one side; a cover hides the middle from frame 4 to 7.
TEST(TrackerLimits, FeaturesDoNotReappearOutsideTheBorderOrUnderTheMask) {
  constexpr int border = 45, hidden_px = 80;
  GrayImage mask = open_mask();
  for (int y = 120; y < 150; ++y) std::fill_n(mask.row(y), image_px, std::uint8_t{0});
  for (const auto& [dx, dy] : {std::pair{3, 0}, {-3, 0}, {0, 3}, {0, -3}}) {
    TrackOptions options = small_options("priority");
    options.corner_border_px = border;
    options.max_travel_px = 0.1;  // so that hardly any is found by its descriptor alone
    Tracker tracker(options);
    int inside = 0;
    for (int k = 0; k < 16; ++k) {
      GrayImage image = waves_at(dx * k, dy * k);
      if (k >= 4 && k <= 11) {
        for (int y = hidden_px; y < image_px - hidden_px; ++y) std::fill_n(image.row(y), image_px, std::uint8_t{128});
        for (int y = 0; y < image_px; ++y)
          std::fill_n(image.row(y) + hidden_px, image_px - 2 * hidden_px, std::uint8_t{128});
      }
      for (const TrackedFeature& feature : tracker.process(image.view(), k, mask.view()).features) {
        if (feature.state != TrackState::reidentified) continue;
        const float nearest = feature.pixel.minCoeff(), farthest = feature.pixel.maxCoeff();
        EXPECT_GE(nearest, static_cast<float>(border) - 0.5F);
        EXPECT_LE(farthest, static_cast<float>(image_px - border) - 0.5F);
        EXPECT_NE(
            mask.at(static_cast<int>(std::lround(feature.pixel.x())), static_cast<int>(std::lround(feature.pixel.y()))),
            0);
        ++inside;
      }
    }
    EXPECT_GT(inside, 5) << dx << ' ' << dy;
  }
}

}  // namespace
}  // namespace rastro
