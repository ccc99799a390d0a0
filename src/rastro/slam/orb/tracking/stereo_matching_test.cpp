// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/tracking/stereo_matching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <utility>

#include "rastro/base/task_pool.h"
#include "rastro/math/median.h"

namespace rastro {
namespace {

/// Smooth texture that never repeats within the image, shifted to the left by `disparity`.
GrayImage textured(double disparity, int height = 240) {
  GrayImage image(480, height);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double u = x + disparity;
      const double wave = std::sin(0.23 * u + 0.11 * y) + std::sin(0.19 * y - 0.013 * u * std::sin(0.05 * y)) +
                          std::sin(0.31 * u - 0.002 * u * y * 0.1);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(128.0 + 40.0 * wave));
    }
  }
  return image;
}

TEST(StereoMatching, DisparitiesAreAccurateToATenthOfAPixel) {
  constexpr double disparity = 12.3, focal_baseline = 246.0;
  const GrayImage left = textured(0.0), right = textured(disparity);
  OrbExtractor extractor(OrbOptions{.features = 400});
  ImageFeatures keyframe;
  keyframe.features = extractor.extract(left.view());
  ASSERT_GT(keyframe.features.size(), 100U);
  match_stereo(left.view(), right.view(), extractor.extract(right.view()), focal_baseline, {}, nullptr, keyframe);
  std::size_t known = 0, right_ones = 0;
  std::vector<double> errors;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (!(keyframe.depths[i] > 0.0F)) continue;
    ++known;
    errors.push_back(std::abs(focal_baseline / static_cast<double>(keyframe.depths[i]) - disparity));
    right_ones += std::abs(focal_baseline / static_cast<double>(keyframe.depths[i]) - disparity) < 0.1 ? 1U : 0U;
    EXPECT_NEAR(static_cast<double>(keyframe.features.keypoints[i].x - keyframe.right_x[i]),
                focal_baseline / static_cast<double>(keyframe.depths[i]), 1e-3);
  }
  EXPECT_GT(known, keyframe.features.size() / 3);
  EXPECT_GT(right_ones, known * 9 / 10);
  EXPECT_LT(upper_median_or(std::move(errors), 1.0), 0.03);
}

TEST(StereoMatching, AnImageOfAnotherSizeHasNoDepth) {
  const GrayImage left = textured(0.0);
  OrbExtractor extractor(OrbOptions{.features = 100});
  ImageFeatures keyframe;
  keyframe.features = extractor.extract(left.view());
  match_stereo(left.view(), GrayImage(100, 100).view(), {}, 100.0, {}, nullptr, keyframe);
  for (const float depth : keyframe.depths) EXPECT_EQ(depth, 0.0F);
}

/// One feature in each of two textured images, the right one at the true disparity unless it is moved.
struct OneFeature {
  static constexpr double disparity = 12.0;
  GrayImage left = textured(0.0), right = textured(disparity);
  ImageFeatures keyframe;
  Features right_features;
  OrbSlamOptions options;

  OneFeature() {
    keyframe.features = feature(200.0F, 100.0F);
    right_features = feature(200.0F - static_cast<float>(disparity), 100.0F);
  }
  static Features feature(float x, float y, std::uint8_t level = 0) {
    Features made;
    made.keypoints.push_back({x, y, 31.0F, 0.0F, 1.0F});
    made.levels.push_back(level);
    made.descriptors.emplace_back();
    return made;
  }
  /// The disparity; 0: none.
  double match() {
    match_stereo(left.view(), right.view(), right_features, 120.0, options, nullptr, keyframe);
    const auto depth = static_cast<double>(keyframe.depths.at(0));
    EXPECT_EQ(depth > 0.0, keyframe.right_x.at(0) >= 0.0F);
    return depth > 0.0 ? 120.0 / depth : 0.0;
  }
};

TEST(StereoMatching, APartnerIsSoughtInTheRowsThatItsSizeReaches) {
  for (const auto& [off, level, found] :
       {std::tuple{2.0F, 0, true}, {-2.0F, 0, true}, {2.1F, 0, false}, {-2.1F, 0, false}, {2.1F, 1, true}}) {
    OneFeature one;
    one.right_features = OneFeature::feature(188.0F, 100.0F + off, static_cast<std::uint8_t>(level));
    EXPECT_EQ(one.match() > 0.0, found) << off << " rows off at level " << level;
  }
}

TEST(StereoMatching, LevelsDifferByAtMostOne) {
  for (const int level : {0, 1, 2, 3, 4}) {
    OneFeature one;
    one.keyframe.features = OneFeature::feature(200.0F, 100.0F, 2);
    one.right_features = OneFeature::feature(188.0F, 100.0F, static_cast<std::uint8_t>(level));
    EXPECT_EQ(one.match() > 0.0, level >= 1 && level <= 3) << level;
  }
}

TEST(StereoMatching, DescriptorsDifferByAtMostTheLimit) {
  for (const int bits : {0, 75, 76}) {
    OneFeature one;
    one.options.stereo_hamming = 75;
    for (int bit = 0; bit < bits; ++bit)
      one.right_features.descriptors[0].words[static_cast<std::size_t>(bit / 64)] ^= std::uint64_t{1} << (bit % 64);
    EXPECT_EQ(one.match() > 0.0, bits <= 75) << bits;
  }
}

TEST(StereoMatching, TheMostSimilarPartnerCounts) {
  OneFeature one;
  Features both = OneFeature::feature(165.0F, 100.0F);
  both.descriptors[0].words[0] = 0xFF;
  const Features& better = one.right_features;
  both.keypoints.push_back(better.keypoints[0]);
  both.levels.push_back(0);
  both.descriptors.push_back(better.descriptors[0]);
  one.right_features = both;
  EXPECT_NEAR(one.match(), OneFeature::disparity, 0.1);
  std::swap(one.right_features.descriptors[0], one.right_features.descriptors[1]);
  EXPECT_NE(one.match(), OneFeature::disparity) << "now the wrong one is more similar";
}

TEST(StereoMatching, APartnerFartherRightOrBeyondTheLargestDisparityIsNone) {
  OneFeature one;
  one.options.stereo_least_disparity_px = 0.0;
  one.right = textured(-1.0);
  one.right_features = OneFeature::feature(201.9F, 100.0F);
  EXPECT_EQ(one.match(), 0.0) << "at a negative disparity there is no depth";
  OneFeature far;
  far.options.stereo_disparity_share = 11.0 / 480.0;
  EXPECT_EQ(far.match(), 0.0);
  far.options.stereo_disparity_share = 12.5 / 480.0;
  EXPECT_NEAR(far.match(), OneFeature::disparity, 0.1);
  far.options.stereo_least_disparity_px = 12.5;
  EXPECT_EQ(far.match(), 0.0);
}

/// Their bands reach beyond the image.
TEST(StereoMatching, FeaturesInTheFirstAndLastRowsHarmNoOthers) {
  for (const int height : {237, 238, 239, 240}) {
    OneFeature one;
    one.left = textured(0.0, height);
    one.right = textured(OneFeature::disparity, height);
    one.keyframe.features = OneFeature::feature(200.0F, 98.0F);
    for (const int row : {0, 1, height - 2, height - 1}) {
      for (int i = 0; i < 50; ++i) {
        one.right_features.keypoints.push_back({400.0F, static_cast<float>(row), 31.0F, 0.0F, 1.0F});
        one.right_features.levels.push_back(7);
        one.right_features.descriptors.emplace_back();
      }
    }
    EXPECT_NEAR(one.match(), OneFeature::disparity, 0.1) << height;
  }
}

TEST(StereoMatching, TheShiftIsSoughtUpToFivePixelsFromThePartner) {
  for (const float off : {-3.0F, 3.0F, 4.0F, 6.0F, -6.0F}) {
    OneFeature one;
    one.right_features = OneFeature::feature(188.0F + off, 100.0F);
    EXPECT_EQ(std::abs(one.match() - OneFeature::disparity) < 0.1, std::abs(off) < 5.0F) << off;
  }
}

TEST(StereoMatching, NextToABorderThereIsNoWindow) {
  for (const auto& [x, y, found] : {std::tuple{200.0F, 5.0F, true},
                                    {200.0F, 4.0F, false},
                                    {200.0F, 234.0F, true},
                                    {200.0F, 235.0F, false},
                                    {22.0F, 100.0F, true},
                                    {21.0F, 100.0F, false},
                                    {474.0F, 100.0F, true},
                                    {475.0F, 100.0F, false}}) {
    OneFeature one;
    one.keyframe.features = OneFeature::feature(x, y);
    one.right_features = OneFeature::feature(x - 12.0F, y);
    EXPECT_EQ(one.match() > 0.0, found) << x << ' ' << y;
  }
}

TEST(StereoMatching, AFeatureWithoutPartnerHasNeitherPositionNorDepth) {
  OneFeature one;
  one.right_features = {};
  EXPECT_EQ(one.match(), 0.0);
  EXPECT_EQ(one.keyframe.right_x.at(0), -1.0F);
  EXPECT_EQ(one.keyframe.depths.at(0), 0.0F);
}

/// The definition of the shift: windows of 11 x 11 pixels, `step` apart, minus their middle one; the least sum of
/// squared differences within five steps of the partner, and the vertex of the parabola through its neighbors.
double plain_disparity(const GrayImage& left, const GrayImage& right, int x, int y, int partner, int step) {
  const auto difference = [&](int at) {
    double sum = 0.0;
    for (int dy = -5; dy <= 5; ++dy) {
      for (int dx = -5; dx <= 5; ++dx) {
        const int a = left.at(x + dx * step, y + dy * step) - left.at(x, y);
        const int b = right.at(at + dx * step, y + dy * step) - right.at(at, y);
        sum += (a - b) * (a - b);
      }
    }
    return sum;
  };
  int best = partner - 5 * step;
  for (int at = best; at <= partner + 5 * step; ++at) best = difference(at) < difference(best) ? at : best;
  if (std::abs(best - partner) == 5 * step) return 0.0;
  const double before = difference(best - 1), middle = difference(best), after = difference(best + 1);
  return x - (best + 0.5 * (before - after) / (before - 2.0 * middle + after));
}

/// With less contrast on the right, the least difference is far from zero.
TEST(StereoMatching, EqualsTheDefinitionAtAnyLevelAndContrast) {
  OneFeature one;
  for (int y = 0; y < one.right.height(); ++y)
    for (int x = 0; x < one.right.width(); ++x)
      one.right.at(x, y) = static_cast<std::uint8_t>(std::lround(64.0 + 0.5 * one.right.at(x, y)));
  int found = 0;
  for (const auto& [level, step] : {std::pair{0, 1}, {2, 1}, {3, 2}, {6, 3}}) {
    for (int x = 120; x < 400; x += 31) {
      one.keyframe.features = OneFeature::feature(static_cast<float>(x), 100.0F, static_cast<std::uint8_t>(level));
      one.right_features = OneFeature::feature(static_cast<float>(x - 11), 100.0F, static_cast<std::uint8_t>(level));
      const double expected = plain_disparity(one.left, one.right, x, 100, x - 11, step);
      const double disparity = one.match();
      EXPECT_NEAR(disparity, expected, 1e-4) << x << " at level " << level;
      found += disparity > 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(found, 20);
}

TEST(StereoMatching, ThreadsGiveTheSameBytes) {
  const GrayImage left = textured(0.0), right = textured(12.3);
  OrbExtractor extractor(OrbOptions{.features = 400});
  ImageFeatures alone, beside;
  alone.features = beside.features = extractor.extract(left.view());
  const Features right_features = extractor.extract(right.view());
  TaskPool pool(3);
  match_stereo(left.view(), right.view(), right_features, 246.0, {}, nullptr, alone);
  match_stereo(left.view(), right.view(), right_features, 246.0, {}, &pool, beside);
  EXPECT_EQ(alone.depths, beside.depths);
  EXPECT_EQ(alone.right_x, beside.right_x);
}

}  // namespace
}  // namespace rastro
