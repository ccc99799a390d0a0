// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/features/feature_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "rastro/map/features/feature_layer.h"

namespace rastro {
namespace {

/// Two keyframes at the origin, each with one feature straight ahead, with the default depth noise.
class TwoViews {
 public:
  TwoViews() {
    Camera camera = camera_from_field_of_view(80.0, 640, 480);
    map_.cameras.push_back({CameraKind::depth, camera, 0.0, {}, SE3()});
    for (const KeyframeId id : {0, 1}) {
      Keyframe& keyframe = map_.keyframes.emplace_back();
      keyframe.id = id;
      ImageFeatures& image = images[static_cast<std::size_t>(id)];
      image.features.keypoints.push_back({static_cast<float>(camera.cx), static_cast<float>(camera.cy), 31, 0, 1});
      image.features.descriptors.emplace_back();
      image.depths.push_back(2.0F);
    }
  }
  ImageFeatures images[2];
  /// The map with the current images.
  const Map& with_images() {
    auto layer = std::make_shared<FeatureLayer>();
    for (const KeyframeId id : {0, 1}) layer->of[id] = std::make_shared<ImageFeatures>(images[id]);
    map_.layers.put<FeatureLayer>(std::move(layer));
    return map_;
  }
  std::vector<FeaturePoint> points() { return feature_points(with_images()); }
  Map& map() { return map_; }

 private:
  Map map_;
};

TEST(FeaturePoints, MatchDepthsWithinThreeSigmasOfBothAndThePose) {
  // Sigma at 2 m: 0.001 + 0.002 * 4; with the pose sigma of 5 mm the limit is 0.0417 m.
  for (const float difference : {0.041F, 0.0425F}) {
    TwoViews views;
    views.images[1].depths[0] = 2.0F + difference;
    EXPECT_EQ(views.points().size(), difference < 0.0417F ? 1U : 0U) << difference;
  }
}

TEST(FeaturePoints, MatchNothingMoreThanFiveCentimetersApart) {
  for (const float difference : {0.0495F, 0.0505F}) {
    TwoViews views;
    views.images[0].depths[0] = 4.0F;
    views.images[1].depths[0] = 4.0F + difference;
    EXPECT_EQ(views.points().size(), difference < 0.05F ? 1U : 0U) << difference;
  }
}

TEST(FeaturePoints, APointIsTheMeanWeightedByTheVariances) {
  TwoViews views;
  views.map().cameras.push_back(views.map().cameras[0]);
  views.map().cameras[1].depth_noise = {0.018, 0.0};
  views.map().keyframes[1].camera = 1;
  views.images[1].depths[0] = 2.03F;
  const auto points = views.points();
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].position.z(), (4.0 * 2.0 + 2.03) / 5.0, 1e-6) << "sigmas 0.009 and 0.018";
  EXPECT_NEAR(points[0].error_px, 0.0, 1e-4);
  EXPECT_EQ(points[0].views.size(), 2U);
}

TEST(FeaturePoints, ErrorIsTheMeanDistanceOfTheProjections) {
  TwoViews views;
  views.images[1].features.keypoints[0].x += 4.0F;  // 4 px at 2 m and fx = 381: 2.1 cm
  const auto points = views.points();
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].error_px, 2.0, 1e-3) << "2 px in each";
}

TEST(FeaturePoints, BinaryDescriptorsMustDifferByFewerThanSixtyBits) {
  for (const int bits : {59, 60}) {
    TwoViews views;
    Descriptor& descriptor = views.images[1].features.descriptors[0];
    for (int bit = 0; bit < bits; ++bit) descriptor.words[static_cast<std::size_t>(bit % 4)] |= std::uint64_t{1} << bit;
    EXPECT_EQ(views.points().size(), bits < 60 ? 1U : 0U) << bits;
  }
}

TEST(FeaturePoints, FloatDescriptorsMustDifferByLessThanAShareOfTheirLength) {
  for (const float difference : {2.95F, 3.05F}) {  // 0.6 times 5
    TwoViews views;
    for (ImageFeatures& image : views.images) {
      image.features.descriptors.clear();
      image.features.length = 2;
      image.features.floats = {3.0F, 4.0F};
    }
    views.images[0].features.floats[1] += difference;
    EXPECT_EQ(views.points().size(), difference < 3.0F ? 1U : 0U) << difference;
    views.images[0].features.length = 0;
    views.images[0].features.descriptors.resize(1);
    EXPECT_TRUE(views.points().empty()) << "of two kinds";
  }
}

TEST(FeaturePoints, OfSeveralTheMostSimilarIsMatched) {
  TwoViews views;
  ImageFeatures& first = views.images[0];
  for (const std::uint64_t word : {0x3FULL, 0x1ULL, 0x7ULL}) {
    first.features.keypoints.push_back(first.features.keypoints[0]);
    first.features.descriptors.push_back({{word, 0, 0, 0}});
    first.depths.push_back(2.0F);
  }
  first.features.descriptors[0].words = {0xFF, 0, 0, 0};
  const auto points = views.points();
  ASSERT_EQ(points.size(), 1U) << "those of one keyframe are not merged";
  EXPECT_EQ(points[0].views.front().feature, 2U);
}

TEST(FeaturePoints, AFeatureWithoutDepthIsNoPoint) {
  TwoViews views;
  views.images[1].depths.clear();
  EXPECT_TRUE(views.points().empty());
  views.images[1].depths = {-1.0F};
  EXPECT_TRUE(views.points().empty());
  views.images[1].depths = {2e6F};
  EXPECT_TRUE(views.points().empty());
  EXPECT_TRUE(feature_points(Map()).empty());
  Map without_camera = views.map();
  without_camera.cameras.clear();
  EXPECT_TRUE(feature_points(without_camera).empty());
}

const LayerType& features_type() { return *layer_type(FeatureLayer::layer_name); }

TEST(FeatureLayer, EachInconsistencyIsReportedAndRemovedByRepair) {
  const std::pair<std::string, std::function<void(ImageFeatures&)>> damages[] = {
      {"not all described", [](auto& image) { image.features.descriptors.emplace_back(); }},
      {"not all described", [](auto& image) { image.features.descriptors.clear(); }},
      {"not all described",
       [](auto& image) {
         image.features.levels = {0, 0};
       }},
      {"not all described", [](auto& image) { image.features.floats.push_back(1.0F); }},
      {"some of its features", [](auto& image) { image.depths.push_back(1.0F); }},
      {"some of its features",
       [](auto& image) {
         image.right_x = {1.0F, 2.0F};
       }},
      {"level that there is not", [](auto& image) { image.features.levels = {8}; }},
  };
  TwoViews sound;
  sound.images[0].features.levels = {7};
  sound.images[0].right_x = {3.0F};
  EXPECT_EQ(contradiction_in(sound.with_images()), "");
  EXPECT_EQ(features_type().rows(*features_type().repaired(sound.map(), sound.map().layer<FeatureLayer>())).size(), 2U);
  for (const auto& [words, damage] : damages) {
    TwoViews views = sound;
    damage(views.images[1]);
    views.with_images();
    EXPECT_NE(contradiction_in(views.map()).find(words), std::string::npos) << contradiction_in(views.map());
    const auto kept = features_type().repaired(views.map(), views.map().layer<FeatureLayer>());
    EXPECT_EQ(features_type().rows(*kept), std::vector<std::int64_t>{0}) << words;
  }
  sound.map().keyframes.pop_back();
  EXPECT_EQ(features_type().rows(*features_type().repaired(sound.map(), sound.map().layer<FeatureLayer>())).size(), 1U);
}

TEST(FeatureLayer, DescribesTheNumberOfFeatures) {
  TwoViews views;
  views.images[0].features.keypoints.resize(5);
  views.images[0].features.descriptors.resize(5);
  views.images[0].depths.clear();
  views.with_images();
  const LayerDescription said = features_type().describe(views.map(), *views.map().layer<FeatureLayer>());
  EXPECT_EQ(said.text, "6 features in 2 keyframes");
  EXPECT_EQ(said.numbers.at(0).second, 6.0);
}

}  // namespace
}  // namespace rastro
