// SPDX-License-Identifier: Apache-2.0
// Which features stay, which are replaced and where new ones begin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "rastro/image/image_testing.h"
#include "rastro/synthetic/worlds/hall.h"
#include "rastro/track/tracker.h"

namespace rastro {
namespace {

constexpr int side_px = 240;

/// Waves of several lengths and directions, rotated by `angle` about the center.
GrayImage rotated_waves(double angle) {
  GrayImage image(side_px, side_px);
  const double c = std::cos(angle), s = std::sin(angle), middle = 0.5 * side_px;
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x) {
      const double u = c * (x - middle) + s * (y - middle), v = c * (y - middle) - s * (x - middle);
      const double value = 128.0 + 30.0 * std::sin(0.21 * u + 0.05 * v) + 25.0 * std::sin(0.17 * v - 0.08 * u + 1.0) +
                           20.0 * std::sin(0.45 * u + 0.31 * v + 2.0) + 15.0 * std::sin(0.53 * v - 0.37 * u + 0.5) +
                           20.0 * std::sin(0.053 * u + 0.043 * v + 0.2);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(value));
    }
  }
  return image;
}

TrackOptions small_features() {
  TrackOptions options;
  options.min_distance_px = 15;
  options.brief_patch_px = 32;
  options.brief_smoothing_px = 5;
  return options;
}

/// Features observed in all of twelve frames, in which the image rotates by 3 degrees each.
int features_that_last(const TrackOptions& options) {
  Tracker tracker(options);
  TrackFrame last;
  for (int k = 0; k < 12; ++k) last = tracker.process(rotated_waves(k * 3.0 * M_PI / 180.0).view(), k);
  return static_cast<int>(std::count_if(last.features.begin(), last.features.end(),
                                        [](const TrackedFeature& feature) { return feature.age == 12; }));
}

/// An older patch is rotated by the known motion before it is compared.
TEST(Tracker, FeaturesOfARotatingImageAreKeptIfItsMotionIsKnown) {
  TrackOptions options = small_features();
  const int foreseen = features_that_last(options);
  options.predict = false;
  const int unforeseen = features_that_last(options);
  EXPECT_GT(foreseen, 40);
  EXPECT_LT(unforeseen, foreseen / 2) << "the patches no longer look alike";
  options.max_reference_residual = 0.0;
  EXPECT_GT(features_that_last(options), foreseen / 2) << "unless nobody compares them";
}

/// Waves that stand still, with other noise in each frame in a square in the middle.
GrayImage with_flicker(int k) {
  GrayImage image = rotated_waves(0.0);
  const GrayImage noise = testing::noise_image(80, 80, static_cast<std::uint64_t>(k + 1));
  for (int y = 0; y < 80; ++y) std::copy_n(noise.row(y), 80, image.row(80 + y) + 80);
  return image;
}

TEST(Tracker, NewFeaturesMustHaveBeenThereInThePreviousFrame) {
  for (const bool verify : {false, true}) {
    TrackOptions options = small_features();
    options.mode = "klt";
    options.verify_corners = verify;
    Tracker tracker(options);
    int flickering = 0;
    for (int k = 0; k < 6; ++k) {
      for (const TrackedFeature& feature : tracker.process(with_flicker(k).view(), k).features) {
        const Eigen::Vector2f off = (feature.pixel - Eigen::Vector2f(120.0F, 120.0F)).cwiseAbs();
        flickering += k > 0 && feature.state == TrackState::fresh && off.maxCoeff() < 28.0F ? 1 : 0;
      }
    }
    EXPECT_EQ(flickering > 5, !verify) << flickering;
    EXPECT_TRUE(!verify || flickering == 0);
  }
}

/// Left and right half move to the right at 2 and 5 pixels a frame, as at two depths; a square in the middle moves
/// down.
GrayImage with_mover(int k) {
  const GrayImage still = rotated_waves(0.0), other = rotated_waves(1.0);
  GrayImage image(side_px, side_px);
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x) {
      const int back = (x < side_px / 2 ? 2 : 5) * k, down = 6 * k;
      const bool in_square = std::abs(x - 120) < 45 && std::abs(y - 80 - down) < 45;
      image.at(x, y) = in_square ? other.at(x, y - down) : still.at((x + side_px - back) % side_px, y);
    }
  }
  return image;
}

/// Features that were followed down with the square in four frames.
int followed_with_the_mover(double max_epipolar_error_px) {
  TrackOptions options = small_features();
  options.mode = "klt";
  options.predict = false;
  options.max_epipolar_error_px = max_epipolar_error_px;
  Tracker tracker(options);
  int followed = 0;
  for (int k = 0; k < 5; ++k) {
    for (const TrackedFeature& feature : tracker.process(with_mover(k).view(), k).features) {
      const Eigen::Vector2f off = (feature.pixel - Eigen::Vector2f(120.0F, 80.0F + 6.0F * k)).cwiseAbs();
      followed += feature.state == TrackState::tracked && off.maxCoeff() < 33.0F ? 1 : 0;
    }
  }
  return followed;
}

TEST(Tracker, FeaturesThatContradictTheEpipolarGeometryAreDropped) {
  EXPECT_GT(followed_with_the_mover(100.0), 20) << "the square has features that can be followed";
  EXPECT_LT(followed_with_the_mover(1.0), 4);
}

const std::vector<GrayImage>& small_hall() {
  static const std::vector<GrayImage> images = [] {
    const World world = make_hall({.scale = 0.5, .threads = 2});
    TaskPool pool(2);
    std::vector<GrayImage> rendered;
    for (int i = 0; i < 24; ++i) rendered.push_back(world.render(i, pool).gray);
    return rendered;
  }();
  return images;
}

std::vector<TrackFrame> tracked_hall(const TrackOptions& options) {
  Tracker tracker(options);
  std::vector<TrackFrame> frames;
  for (const GrayImage& image : small_hall())
    frames.push_back(tracker.process(image.view(), static_cast<TimeNs>(frames.size())));
  return frames;
}

TEST(Tracker, NoFeatureBeginsWhereOneWasJustLost) {
  for (const char* mode : {"klt", "priority"}) {
    TrackOptions options = small_features();
    options.mode = mode;
    const std::vector<TrackFrame> frames = tracked_hall(options);
    int lost = 0;
    for (std::size_t k = 1; k < frames.size(); ++k) {
      if (2 * frames[k].tracked < frames[k].tracked + frames[k].lost) continue;
      for (const TrackedFeature& before : frames[k - 1].features) {
        const auto same = [&](const TrackedFeature& feature) { return feature.id == before.id; };
        if (std::any_of(frames[k].features.begin(), frames[k].features.end(), same)) continue;
        ++lost;
        for (const TrackedFeature& feature : frames[k].features) {
          if (feature.state != TrackState::fresh) continue;
          EXPECT_GE((feature.pixel - before.pixel).norm(), static_cast<float>(options.min_distance_px)) << k;
        }
      }
    }
    EXPECT_GT(lost, 50);
  }
}

/// With a full frame, lost features that reappear may take the place of the youngest, a tenth of all in a frame.
TEST(Tracker, ReappearingFeaturesDisplaceTheYoungestOnesIfAllowed) {
  TrackOptions options = small_features();
  options.features = 40;
  options.predict = false;
  std::map<bool, int> reidentified;
  for (const bool displace : {false, true}) {
    options.displace = displace;
    for (const TrackFrame& frame : tracked_hall(options)) {
      EXPECT_LE(frame.features.size(), 40U);
      EXPECT_EQ(frame.tracked + frame.fresh + frame.reidentified, static_cast<int>(frame.features.size()));
      reidentified[displace] += frame.reidentified;
    }
  }
  EXPECT_GT(reidentified[true], reidentified[false]);
}

/// The guided search makes its descriptors as those it compares them with were made.
TEST(Tracker, LostFeaturesReappearWithEveryDescriptor) {
  for (const char* descriptor : {"upright", "scaled", "steered", "steered_scaled"}) {
    TrackOptions options = small_features();
    options.descriptor = descriptor;
    options.max_travel_px = 0.1;  // so that hardly any corner is compared with a lost feature
    int reidentified = 0;
    for (const TrackFrame& frame : tracked_hall(options)) reidentified += frame.reidentified;
    EXPECT_GT(reidentified, 40) << descriptor << ", measured: 62 or more";
  }
}

/// Waves that stand still; in frames 6 and 7 a blank square covers their middle.
GrayImage with_cover(int k) {
  GrayImage image = rotated_waves(0.0);
  if (k < 6 || k > 7) return image;
  for (int y = 60; y < 180; ++y) std::fill_n(image.row(y) + 60, 120, std::uint8_t{128});
  return image;
}

/// What was covered comes back, and the ones that took its place meanwhile go.
TEST(Tracker, TheYoungestAreDisplacedAndTheOldestStay) {
  TrackOptions options = small_features();
  options.features = 60;
  options.predict = false;
  options.displace = true;
  Tracker tracker(options);
  std::vector<TrackFrame> frames;
  for (int k = 0; k <= 8; ++k) frames.push_back(tracker.process(with_cover(k).view(), k));
  const TrackFrame &before = frames[7], &after = frames[8];
  ASSERT_EQ(before.features.size(), 60U) << "full";
  EXPECT_EQ(after.reidentified, 6) << "a tenth";
  EXPECT_EQ(after.features.size(), 60U);
  for (const TrackedFeature& feature : before.features) {
    const bool stays = std::any_of(after.features.begin(), after.features.end(),
                                   [&](const TrackedFeature& other) { return other.id == feature.id; });
    EXPECT_TRUE(stays || feature.age < 3) << feature.age;
  }
}

}  // namespace
}  // namespace rastro
