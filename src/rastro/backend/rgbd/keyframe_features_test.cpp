// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/keyframe_features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::looking;
using testing::room_frame;
using testing::unknown_frame;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinite = std::numeric_limits<float>::infinity();

/// 9 x 9 pixels of 2 m.
DepthImage patch() {
  DepthImage depth(9, 9);
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 9; ++x) depth.at(x, y) = 2.0F;
  return depth;
}

TEST(FeatureDepth, IsTheMedianOfFiveByFive) {
  DepthImage depth = patch();
  float value = 2.0F;
  for (int y = 2; y <= 6; ++y)
    for (int x = 2; x <= 6; ++x) depth.at(x, y) = value += 0.001F;
  EXPECT_NEAR(feature_depth(depth, 4.0F, 4.0F), 2.013F, 1e-5F);
  EXPECT_NEAR(feature_depth(depth, 4.4F, 3.6F), 2.013F, 1e-5F) << "of the nearest pixel";
  depth = patch();
  depth.at(4, 4) = 2.05F;
  EXPECT_EQ(feature_depth(depth, 4.0F, 4.0F), 2.0F) << "one noisy pixel, its own even, says nothing";
}

TEST(FeatureDepth, HasNoneAtADepthEdge) {
  for (const float other : {2.09F, 1.9F, 6.0F}) {
    DepthImage depth = patch();
    for (int y = 0; y < 9; ++y) depth.at(6, y) = other;
    EXPECT_EQ(feature_depth(depth, 4.0F, 4.0F), 0.0F) << other;
    EXPECT_EQ(feature_depth(depth, 3.0F, 4.0F), 2.0F) << "one pixel farther from the edge";
  }
}

TEST(FeatureDepth, WhatTheNoiseExplainsIsNoEdge) {
  const DepthNoise of_stereo{0.0, 0.02};  // 8 cm at 2 m
  for (const float other : {2.22F, 2.26F}) {
    DepthImage depth = patch();
    for (int y = 0; y < 9; ++y) depth.at(6, y) = other;
    EXPECT_EQ(feature_depth(depth, 4.0F, 4.0F), 0.0F) << other;
    EXPECT_EQ(feature_depth(depth, 4.0F, 4.0F, of_stereo), other < 2.24F ? 2.0F : 0.0F) << other;
  }
}

TEST(FeatureDepth, MissingPixelsDoNotCountAndTooManyGiveNone) {
  for (const float missing : {0.0F, -1.0F, nan, infinite}) {
    DepthImage depth = patch();
    int holes = 0;
    for (int y = 2; y <= 6 && holes < 12; ++y)
      for (int x = 2; x <= 6 && holes < 12; ++x, ++holes) depth.at(x, y) = missing;
    EXPECT_EQ(feature_depth(depth, 4.0F, 4.0F), 2.0F) << missing << ": 13 of 25 are left";
    depth.at(4, 4) = missing;
    EXPECT_EQ(feature_depth(depth, 4.0F, 4.0F), 0.0F) << missing;
  }
}

TEST(FeatureDepth, HasNoneAtTheImageBorder) {
  const DepthImage depth = patch();
  for (const float coordinate : {-3.0F, 0.0F, 1.0F, 7.0F, 8.0F, 30.0F}) {
    EXPECT_EQ(feature_depth(depth, coordinate, 4.0F), 0.0F) << coordinate;
    EXPECT_EQ(feature_depth(depth, 4.0F, coordinate), 0.0F) << coordinate;
  }
  EXPECT_EQ(feature_depth(depth, 2.0F, 6.0F), 2.0F);
  EXPECT_EQ(feature_depth(DepthImage(), 4.0F, 4.0F), 0.0F);
}

RgbdSlamOptions few_features(int count) {
  RgbdSlamOptions options;
  options.keyframe_features = count;
  return options;
}

TEST(KeyframeFeatures, EachHasTheCorrectDepthOrNone) {
  const Frame frame = room_frame(looking({-1.2, 0.1, 1.2}, 0.1), 42);
  const RgbdSlamOptions options;
  const ImageFeatures keyframe = KeyframeFeatures(options).extract(frame);
  EXPECT_EQ(keyframe.frame, 42);
  EXPECT_EQ(keyframe.stamp, frame.stamp);
  ASSERT_EQ(keyframe.depths.size(), keyframe.features.size());
  ASSERT_EQ(keyframe.features.descriptors.size(), keyframe.features.size());
  EXPECT_GT(keyframe.features.size(), 300U);
  EXPECT_LE(keyframe.features.size(), static_cast<std::size_t>(options.keyframe_features));
  int known = 0;
  for (std::size_t i = 0; i < keyframe.depths.size(); ++i) {
    if (keyframe.depths[i] == 0.0F) continue;
    ++known;
    const Keypoint& point = keyframe.features.keypoints[i];
    const float exact = frame.depth.at(static_cast<int>(std::lround(point.x)), static_cast<int>(std::lround(point.y)));
    EXPECT_NEAR(keyframe.depths[i], exact, 0.03F * exact);
  }
  EXPECT_GT(known, 200);
}

TEST(KeyframeFeatures, DepthsBeyondTheRangeAreNone) {
  RgbdSlamOptions options;
  options.follow.min_depth_m = 1.5;
  options.follow.max_depth_m = 2.5;
  const Frame frame = room_frame(looking({-1.2, 0.1, 1.2}, 0.1));
  const ImageFeatures limited = KeyframeFeatures(options).extract(frame), all = KeyframeFeatures({}).extract(frame);
  ASSERT_EQ(limited.depths.size(), all.depths.size());
  int within = 0;
  for (std::size_t i = 0; i < all.depths.size(); ++i) {
    const bool allowed = all.depths[i] >= 1.5F && all.depths[i] <= 2.5F;
    within += allowed ? 1 : 0;
    EXPECT_EQ(limited.depths[i], allowed ? all.depths[i] : 0.0F);
  }
  EXPECT_GT(within, 10);
  EXPECT_LT(within, static_cast<int>(all.depths.size()) - 10);
}

std::array<int, 48> count_by_cell(const ImageFeatures& keyframe) {
  std::array<int, 48> cells{};
  for (const Keypoint& point : keyframe.features.keypoints)
    ++cells[static_cast<std::size_t>(static_cast<int>(point.y) / 40 * 8 + static_cast<int>(point.x) / 40)];
  return cells;
}

/// The left half has stronger edges than the right one: nearly all of the strongest features are at the left.
TEST(KeyframeFeatures, AreSpreadOverTheImage) {
  Frame frame = unknown_frame(3);
  for (int y = 0; y < 240; ++y)
    for (int x = 160; x < 320; ++x) frame.image.at(x, y) = static_cast<std::uint8_t>(60 + frame.image.at(x, y) / 2);
  const ImageFeatures keyframe = KeyframeFeatures(few_features(300)).extract(frame);
  ASSERT_EQ(keyframe.features.size(), 300U);
  DescriptorExtractorOptions plain;
  plain.max_keypoints = 600;
  ImageFeatures all, strongest;
  all.features = DescriptorExtractor::create(DescriptorKind::orb, plain)->extract(frame.image);
  strongest.features.keypoints.assign(all.features.keypoints.begin(), all.features.keypoints.begin() + 300);
  const auto cells = count_by_cell(keyframe), found = count_by_cell(all), without = count_by_cell(strongest);
  const auto at_right = [](const std::array<int, 48>& counts) {
    int sum = 0;
    for (std::size_t cell = 0; cell < 48; ++cell) sum += cell % 8 >= 4 ? counts[cell] : 0;
    return sum;
  };
  EXPECT_GT(at_right(cells), 2 * at_right(without));
  const int most = *std::max_element(cells.begin(), cells.end());
  for (std::size_t cell = 0; cell < 48; ++cell)
    EXPECT_GE(cells[cell], std::min(found[cell], most - 1)) << "no cell has two more before another has its next";
}

TEST(KeyframeFeatures, AreStrongestFirst) {
  const ImageFeatures keyframe = KeyframeFeatures(few_features(150)).extract(unknown_frame(5));
  const auto& points = keyframe.features.keypoints;
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end(),
                             [](const Keypoint& a, const Keypoint& b) { return a.response > b.response; }));
}

TEST(KeyframeFeatures, NoneWhereTheMaskIsZero) {
  Frame frame = unknown_frame(7);
  frame.mask = GrayImage(320, 240);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) frame.mask.at(x, y) = x < 200 ? 255 : 0;
  const ImageFeatures keyframe = KeyframeFeatures({}).extract(frame);
  EXPECT_GT(keyframe.features.size(), 100U);
  for (const Keypoint& point : keyframe.features.keypoints) EXPECT_LT(std::lround(point.x), 200);
}

TEST(KeyframeFeatures, DescriptorsStayWithTheirKeypoints) {
  const Frame frame = unknown_frame(9);
  for (const char* kind : {"orb", "sift"}) {
    RgbdSlamOptions options = few_features(120);
    options.descriptor = kind;
    const ImageFeatures keyframe = KeyframeFeatures(options).extract(frame);
    DescriptorExtractorOptions plain;
    plain.max_keypoints = 2 * options.keyframe_features;
    const Features all = DescriptorExtractor::create(descriptor_kind(kind, "test"), plain)->extract(frame.image);
    const auto length = static_cast<std::size_t>(all.length);
    EXPECT_EQ(keyframe.features.length, all.length);
    ASSERT_EQ(keyframe.features.floats.size(), length * keyframe.features.size());
    std::size_t next = 0;  // the chosen ones keep the order of all
    for (std::size_t i = 0; i < keyframe.features.size(); ++i, ++next) {
      const Keypoint& point = keyframe.features.keypoints[i];
      while (next < all.size() && (all.keypoints[next].x != point.x || all.keypoints[next].y != point.y ||
                                   all.keypoints[next].angle_rad != point.angle_rad))
        ++next;
      ASSERT_LT(next, all.size());
      if (length == 0) {
        EXPECT_EQ(keyframe.features.descriptors[i], all.descriptors[next]);
      }
      for (std::size_t k = 0; k < length; ++k)
        ASSERT_EQ(keyframe.features.floats[i * length + k], all.floats[next * length + k]);
    }
  }
}

TEST(KeyframeFeatures, AUniformImageHasNone) {
  Frame frame = unknown_frame(1);
  for (int y = 0; y < 240; ++y) std::fill_n(frame.image.row(y), 320, std::uint8_t{90});
  const ImageFeatures keyframe = KeyframeFeatures({}).extract(frame);
  EXPECT_EQ(keyframe.features.size(), 0U);
  EXPECT_TRUE(keyframe.depths.empty());
}

}  // namespace
}  // namespace rastro
