// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/refinement/photometric_bundle.h"

#include <gtest/gtest.h>

#include <vector>

#include "rastro/slam/lsd/refinement/plane_views_testing.h"

namespace rastro {
namespace {

using testing::plane_camera, testing::PlaneViews;

TEST(PhotometricBundle, FindsPosesAndDepths) {
  for (const double gain : {1.0, 0.8}) {
    PlaneViews scene(gain), truth(gain);
    const double best = adjust_photometric_bundle(truth.keyframes, plane_camera(), {}).first_cost;
    scene.disturb(7);
    const double before = scene.error(), depths_before = scene.depth_error();
    const PhotometricBundleResult result = adjust_photometric_bundle(scene.keyframes, plane_camera(), {});
    EXPECT_LT(result.last_cost - best, 0.1 * (result.first_cost - best)) << gain;
    EXPECT_LT(scene.error(), 0.01) << gain;
    EXPECT_LT(scene.error(), 0.3 * before) << gain;
    EXPECT_LT(scene.depth_error(), 0.3 * depths_before) << gain;
  }
}

TEST(PhotometricBundle, WhatIsRightStays) {
  PlaneViews scene;
  adjust_photometric_bundle(scene.keyframes, plane_camera(), {});
  EXPECT_LT(scene.error(), 0.003);
  EXPECT_LT(scene.depth_error(), 0.005);
}

TEST(PhotometricBundle, MeasuredDepthsKeepTheScale) {
  PlaneViews scene;
  for (PhotometricKeyframe& keyframe : scene.keyframes)
    for (PhotometricPoint& point : keyframe.points) point.measured = point.inverse_depth, point.measured_sigma = 0.01;
  scene.disturb(11);
  for (PhotometricKeyframe& keyframe : scene.keyframes)
    for (PhotometricPoint& point : keyframe.points) point.inverse_depth *= 0.97;
  adjust_photometric_bundle(scene.keyframes, plane_camera(), {.iterations = 20});
  EXPECT_NEAR(scene.scale(), 1.0, 0.005);
  EXPECT_LT(scene.error(), 0.01);
}

TEST(PhotometricBundle, EqualBytesForAnyPool) {
  TaskPool pool(3);
  PlaneViews one, three;
  one.disturb(5);
  three.disturb(5);
  adjust_photometric_bundle(one.keyframes, plane_camera(), {});
  adjust_photometric_bundle(three.keyframes, plane_camera(), {}, &pool);
  for (std::size_t k = 0; k < one.keyframes.size(); ++k) {
    EXPECT_EQ(one.keyframes[k].camera_from_world.matrix(), three.keyframes[k].camera_from_world.matrix());
    EXPECT_EQ(one.keyframes[k].points.front().inverse_depth, three.keyframes[k].points.front().inverse_depth);
  }
}

TEST(PhotometricBundle, EndsWhereItIsStopped) {
  PlaneViews scene;
  scene.disturb(3);
  const double before = scene.error();
  EXPECT_EQ(adjust_photometric_bundle(scene.keyframes, plane_camera(), {.stopped = [] { return true; }}).iterations, 0);
  EXPECT_EQ(scene.error(), before);
}

/// What stands before the camera in a part of each image, as a hood does.
TEST(PhotometricBundle, WhatIsMaskedDoesNotCount) {
  PlaneViews scene, hidden;
  GrayImage mask(plane_camera().width, plane_camera().height);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) mask.at(x, y) = y < 80 || x < 40 ? 255 : 0;
  for (GrayImage& image : hidden.images)
    for (int y = 0; y < mask.height(); ++y)
      for (int x = 0; x < mask.width(); ++x)
        if (mask.at(x, y) == 0) image.at(x, y) = static_cast<std::uint8_t>(60 + 90 * ((x / 5 + y / 5) % 2));
  for (PlaneViews* views : {&scene, &hidden}) {
    views->disturb(7);
    for (PhotometricKeyframe& keyframe : views->keyframes) keyframe.mask = mask.view();
    const PhotometricBundleResult result = adjust_photometric_bundle(views->keyframes, plane_camera(), {});
    EXPECT_GT(result.residuals, 0);
  }
  for (std::size_t k = 0; k < scene.keyframes.size(); ++k)
    EXPECT_EQ(scene.keyframes[k].camera_from_world.matrix(), hidden.keyframes[k].camera_from_world.matrix());
}

TEST(PhotometricBundle, NothingToCompareChangesNothing) {
  std::vector<PhotometricKeyframe> none;
  EXPECT_EQ(adjust_photometric_bundle(none, plane_camera(), {}).residuals, 0);
  PlaneViews scene;
  for (PhotometricKeyframe& keyframe : scene.keyframes) keyframe.targets.clear();
  const PhotometricBundleResult result = adjust_photometric_bundle(scene.keyframes, plane_camera(), {});
  EXPECT_EQ(result.residuals, 0);
  EXPECT_EQ(result.last_cost, result.first_cost);
  EXPECT_LT(scene.error(), 1e-12);
}

}  // namespace
}  // namespace rastro
