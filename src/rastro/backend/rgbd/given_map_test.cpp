// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/given_map.h"

#include <gtest/gtest.h>

#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/base/error.h"

namespace rastro {
namespace {

SlamContext context_of(Map map) {
  SlamContext context;
  context.map = std::make_shared<const Map>(std::move(map));
  return context;
}

TEST(GivenMap, ANewMapHasTheCameraItsNoiseAndOneMetricSession) {
  RgbdSlamOptions options;
  options.follow.depth_sigma_m = 0.004;
  options.follow.depth_sigma_per_m2 = 0.003;
  const Map map = base_map("rgbd", options, test_room::camera());
  EXPECT_EQ(map.method, "rgbd");
  ASSERT_EQ(map.cameras.size(), 1U);
  EXPECT_EQ(map.cameras[0].kind, CameraKind::depth);
  EXPECT_EQ(map.cameras[0].intrinsics.fx, 260.0);
  EXPECT_EQ(map.cameras[0].baseline, 0.0);
  EXPECT_NEAR(map.cameras[0].depth_noise.sigma(2.0), 0.016, 1e-12);
  ASSERT_EQ(map.sessions.size(), 1U);
  EXPECT_EQ(map.sessions[0].robot, 0);
  EXPECT_EQ(map.sessions[0].session, 0);
  EXPECT_TRUE(map.sessions[0].scale.metric);
  EXPECT_EQ(map.sessions[0].scale.origin, "depth camera");
  EXPECT_TRUE(map.keyframes.empty());
}

/// 1 % of the width of 320 pixels.
TEST(GivenMap, ItsCameraMayDifferByAsMuchAsCalibrationsDo) {
  const SlamContext given = context_of(make_test_map(2));
  for (double Camera::*parameter : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy}) {
    for (const double off_px : {-3.3, -3.1, 3.1, 3.3}) {
      Camera camera = test_room::camera();
      camera.*parameter += off_px;
      if (std::abs(off_px) < 3.2) {
        EXPECT_NO_THROW(with_usable_map(given, camera)) << off_px;
      } else {
        EXPECT_THROW(with_usable_map(given, camera), Error) << off_px;
      }
    }
  }
  for (int Camera::*size : {&Camera::width, &Camera::height}) {
    Camera camera = test_room::camera();
    camera.*size += 1;
    EXPECT_THROW(with_usable_map(given, camera), Error);
  }
}

TEST(GivenMap, ItsFeaturesMustBeOfTheSameKind) {
  const SlamContext given = context_of(make_test_map(2));
  RgbdSlamOptions options;
  EXPECT_NO_THROW(with_usable_map(given, test_room::camera(), options));
  options.descriptor = "sift";
  try {
    with_usable_map(given, test_room::camera(), options);
    FAIL() << "these are bits";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("descriptor=orb or even_orb"), std::string::npos) << error.what();
  }
}

/// They leave memory, and a map of `rgbd` has no long-term memory yet.
TEST(GivenMap, OneThatIsContinuedHasItsFeaturesInLongTermMemory) {
  SlamContext given = context_of(make_test_map(3));
  const auto before = given.map->layer<FeatureLayer>();
  given.extend_map = true;
  const auto map = with_usable_map(given, test_room::camera()).map;
  for (const Keyframe& keyframe : map->keyframes) {
    EXPECT_EQ(map->layer<FeatureLayer>()->of.at(keyframe.id)->features.size(), 0U);
    const Signature signature = signature_of(*map, keyframe.id);
    EXPECT_EQ(signature.image->features.descriptors, before->of.at(keyframe.id)->features.descriptors);
    EXPECT_EQ(signature.image->depths, before->of.at(keyframe.id)->depths);
  }
}

TEST(GivenMap, EveryKeyframeNeedsFeaturesTheirDepthsAndImages) {
  const Camera camera = test_room::camera();
  EXPECT_FALSE(with_usable_map({}, camera).map) << "without a map there is nothing to refuse";
  EXPECT_EQ(with_usable_map(context_of(make_test_map(3)), camera).map->keyframes.size(), 3U);
  Map without_features = make_test_map(3);
  auto features = std::make_shared<FeatureLayer>(*without_features.layer<FeatureLayer>());
  features->of.erase(1);
  without_features.layers.put<FeatureLayer>(std::move(features));
  EXPECT_THROW(with_usable_map(context_of(without_features), camera), Error);
  Map without_images = make_test_map(3);
  auto images = std::make_shared<ImageLayer>(*without_images.layer<ImageLayer>());
  std::erase(images->keyframes, 1);
  without_images.layers.put<ImageLayer>(std::move(images));
  EXPECT_THROW(with_usable_map(context_of(without_images), camera), Error);
}

}  // namespace
}  // namespace rastro
