// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/images/pack_images.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/map/features/feature_points.h"
#include "rastro/map/images/room_map_testing.h"

namespace rastro {
namespace {

/// Smooth colors and depths from 0.5 to 12.5 m.
Frame some_frame(int width = 64, int height = 48) {
  Frame frame;
  frame.image = GrayImage(width, height);
  frame.color.rgb = Image<std::uint8_t>(3 * width, height);
  frame.depth = DepthImage(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      frame.image.at(x, y) = static_cast<std::uint8_t>(60 + 2 * x);
      frame.color.rgb.at(3 * x, y) = 200;
      frame.color.rgb.at(3 * x + 1, y) = static_cast<std::uint8_t>(20 + 3 * x);
      frame.color.rgb.at(3 * x + 2, y) = 50;
      frame.depth.at(x, y) = 0.5F + 12.0F * static_cast<float>(y * width + x) / static_cast<float>(width * height);
    }
  }
  return frame;
}

TEST(PackImages, DepthComesBackToATenthOfAMillimeter) {
  const Frame frame = some_frame();
  const UnpackedImages back = unpack_images(pack_images(frame), "test");
  ASSERT_EQ(back.depth.width(), 64);
  ASSERT_EQ(back.depth.height(), 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) EXPECT_NEAR(back.depth.at(x, y), frame.depth.at(x, y), 1.01e-4F);
}

TEST(PackImages, DepthThatCannotBeStoredIsZero) {
  Frame frame = some_frame();
  const float bad[] = {
      0.0F, -1.0F, 13.2F, 1e9F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(), 5e-5F};
  for (int k = 0; k < 7; ++k) frame.depth.at(k, 3) = bad[k];
  frame.depth.at(7, 3) = 13.106F;
  const UnpackedImages back = unpack_images(pack_images(frame), "test");
  for (int k = 0; k < 7; ++k) EXPECT_EQ(back.depth.at(k, 3), 0.0F) << bad[k];
  EXPECT_NEAR(back.depth.at(7, 3), 13.106F, 1.01e-4F) << "the farthest that fits 16 bits";
}

TEST(PackImages, PackedTwiceItIsTheSame) {
  const Frame frame = some_frame();
  const PackedImages once = pack_images(frame);
  EXPECT_EQ(once, pack_images(frame));
  const UnpackedImages back = unpack_images(once, "test");
  Frame again = frame;
  again.depth = back.depth;
  EXPECT_EQ(pack_images(again).depth, once.depth) << "what was packed loses nothing any more";
  EXPECT_EQ(once.bytes(), once.color.size() + once.depth.size());
}

TEST(PackImages, AShrunkGrayImageShowsTheMeansOfBlocks) {
  const Frame frame = some_frame();
  const PackedImages packed = pack_images(frame);
  const GrayImage whole = gray_from_color(unpack_images(packed, "test").color);
  for (const int shrink : {1, 2, 4, 8}) {
    const GrayImage small = unpack_gray(packed, shrink, "test");
    ASSERT_EQ(small.width(), 64 / shrink);
    ASSERT_EQ(small.height(), 48 / shrink);
    for (int y = 0; y < small.height(); ++y)
      for (int x = 0; x < small.width(); ++x) {
        double sum = 0.0;
        for (int k = 0; k < shrink * shrink; ++k) sum += whole.at(shrink * x + k % shrink, shrink * y + k / shrink);
        EXPECT_NEAR(small.at(x, y), sum / (shrink * shrink), 3.0) << shrink << ' ' << x << ' ' << y;
      }
  }
  EXPECT_THROW(unpack_gray({{1, 2, 3}, packed.depth}, 4, "test"), Error);
}

TEST(PackImages, ColorsKeepTheirOrderAndGrayHasThreeEqualChannels) {
  Frame frame = some_frame();
  UnpackedImages back = unpack_images(pack_images(frame), "test");
  ASSERT_EQ(back.color.width(), 64);
  for (int x = 8; x < 56; x += 8) {
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(back.color.rgb.at(3 * x + channel, 24), frame.color.rgb.at(3 * x + channel, 24), 12) << channel;
  }
  frame.color.rgb = {};
  back = unpack_images(pack_images(frame), "test");
  for (int x = 8; x < 56; x += 8) {
    EXPECT_NEAR(back.color.rgb.at(3 * x, 24), frame.image.at(x, 24), 4);
    EXPECT_EQ(back.color.rgb.at(3 * x, 24), back.color.rgb.at(3 * x + 1, 24));
    EXPECT_EQ(back.color.rgb.at(3 * x, 24), back.color.rgb.at(3 * x + 2, 24));
  }
}

TEST(PackImages, WithoutDepthItIsZeroEverywhere) {
  Frame frame = some_frame();
  frame.depth = {};
  const UnpackedImages back = unpack_images(pack_images(frame), "test");
  ASSERT_EQ(back.depth.width(), 64);
  for (int y = 0; y < 48; ++y) EXPECT_EQ(*std::max_element(back.depth.row(y), back.depth.row(y) + 64), 0.0F);
}

TEST(PackImages, DamageAndTwoSizesAreErrorsWithTheLocation) {
  const PackedImages sound = pack_images(some_frame()), small = pack_images(some_frame(32, 48));
  PackedImages cut = sound, junk = sound, none;
  cut.depth.resize(20);
  junk.color.assign(500, 77);
  for (const PackedImages& damaged : {cut, junk, none, PackedImages{sound.color, small.depth},
                                      PackedImages{sound.color, sound.color}, PackedImages{{}, sound.depth}}) {
    try {
      unpack_images(damaged, "keyframe 7");
      ADD_FAILURE() << "was taken";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("keyframe 7"), std::string::npos);
    }
  }
}

TEST(PackImages, TheDepthAloneIsThatOfBoth) {
  const auto equal = [](const DepthImage& a, const DepthImage& b) {
    if (a.width() != b.width() || a.height() != b.height()) return false;
    for (int y = 0; y < a.height(); ++y)
      if (!std::equal(a.row(y), a.row(y) + a.width(), b.row(y))) return false;
    return true;
  };
  Frame without = some_frame();
  without.depth = {};
  for (const Frame& frame : {some_frame(), without}) {
    const PackedImages packed = pack_images(frame);
    EXPECT_TRUE(equal(unpack_depth(packed, "test"), unpack_images(packed, "test").depth));
  }
  PackedImages cut = pack_images(some_frame()), color = cut;
  cut.depth.resize(20);
  color.depth = color.color;
  for (const PackedImages& damaged : {cut, color, PackedImages{}}) EXPECT_THROW(unpack_depth(damaged, "it"), Error);
}

TEST(MemoryImages, GiveBackWhatWasAddedLast) {
  MemoryImages images;
  const PackedImages one = pack_images(some_frame()), other = pack_images(some_frame(32, 48));
  images.add(3, one);
  images.add(4, other);
  EXPECT_EQ(images.read(3), one);
  EXPECT_EQ(images.read(4), other);
  images.add(3, other);
  EXPECT_EQ(images.read(3), other);
  EXPECT_THROW(images.read(5), Error);
}

/// A map whose keyframes observe these world points exactly, each with its own descriptor.
Map map_of_points(const std::vector<Eigen::Vector3d>& points, int keyframes) {
  Map map;
  map.cameras.push_back({CameraKind::depth, test_room::camera(), 0.0, {}, SE3()});
  auto features = std::make_shared<FeatureLayer>();
  Random random(5);
  std::vector<Descriptor> descriptors(points.size());
  for (Descriptor& descriptor : descriptors)
    for (std::uint64_t& word : descriptor.words) word = random.next();
  for (int k = 0; k < keyframes; ++k) {
    auto image = std::make_shared<ImageFeatures>();
    image->id = k;
    const SE3 pose(SO3::exp({0.0, 0.02 * k, 0.0}), {0.1 * k, 0.0, 0.0});
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d p = pose.inverse() * points[i];
      const auto pixel = test_room::camera().project(p);
      image->features.keypoints.push_back({static_cast<float>(pixel->x()), static_cast<float>(pixel->y()), 31, 0, 1});
      image->features.descriptors.push_back(descriptors[i]);
      image->depths.push_back(static_cast<float>(p.z()));
    }
    features->of[k] = image;
    map.keyframes.push_back({k, k, k, 0, pose, 0, no_keyframe, 1.0});
  }
  map.layers.put<FeatureLayer>(std::move(features));
  return map;
}

std::vector<Eigen::Vector3d> grid_of_points() {
  std::vector<Eigen::Vector3d> points;
  for (int y = -2; y <= 2; ++y)
    for (int x = -3; x <= 3; ++x) points.emplace_back(0.2 * x, 0.2 * y, 2.0 + 0.05 * (x + y));
  return points;
}

TEST(FeaturePointsOfAMap, AreTheObservedPoints) {
  const auto ground_truth = grid_of_points();
  const std::vector<FeaturePoint> points = feature_points(map_of_points(ground_truth, 4));
  ASSERT_EQ(points.size(), ground_truth.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT((points[i].position - ground_truth[i]).norm(), 1e-4) << i;
    EXPECT_LT(points[i].error_px, 0.01);
    ASSERT_EQ(points[i].views.size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(points[i].views[k].keyframe, k);
      EXPECT_EQ(points[i].views[k].feature, i);
    }
  }
}

TEST(FeaturePointsOfAMap, SimilarFeaturesElsewhereAndDifferentOnesAtTheSamePositionAreNotMatched) {
  const auto ground_truth = grid_of_points();
  Map map = map_of_points(ground_truth, 2);
  auto features = std::make_shared<FeatureLayer>(*map.layer<FeatureLayer>());
  auto changed = std::make_shared<ImageFeatures>(*features->of[1]);
  for (std::uint64_t& word : changed->features.descriptors[0].words) word = ~word;  // a different descriptor
  changed->depths[1] += 0.1F;                                                       // elsewhere
  changed->depths[2] = 0.0F;                                                        // not measured
  features->of[1] = changed;
  map.layers.put<FeatureLayer>(std::move(features));
  const std::vector<FeaturePoint> points = feature_points(map);
  EXPECT_EQ(points.size(), ground_truth.size() - 3);
  for (const FeaturePoint& point : points) EXPECT_GE(point.views.front().feature, 3U);
}

TEST(FeaturePointsOfAMap, UseOnlyTheSubmapAskedFor) {
  Map map = map_of_points(grid_of_points(), 4);
  map.keyframes[2].submap = map.keyframes[3].submap = 1;
  for (const FeaturePoint& point : feature_points(map, 1)) {
    EXPECT_EQ(point.views.size(), 2U);
    EXPECT_GE(point.views.front().keyframe, 2U);
  }
  EXPECT_FALSE(feature_points(map, 1).empty());
  EXPECT_TRUE(feature_points(map, 5).empty());
}

}  // namespace
}  // namespace rastro
