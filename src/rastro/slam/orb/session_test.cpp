// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/session.h"

#include <gtest/gtest.h>

#include "rastro/slam/orb/session_testing.h"

namespace rastro {
namespace {

TEST(OrbSession, TakesSensorFeaturesAndViewsFromItsOptions) {
  OrbSlamOptions options;
  options.features = 321;
  options.scale_factor = 1.5;
  options.local_keyframes = 7;
  options.local_landmarks = 123;
  const Camera camera = testing::PointWorld(1, 1).camera;
  const OrbSession depth(options, testing::source_of(camera, CameraKind::depth), {});
  EXPECT_FALSE(depth.mono());
  EXPECT_EQ(depth.graph.sensor(), CameraKind::depth);
  EXPECT_DOUBLE_EQ(depth.graph.baseline(), options.virtual_baseline_m);
  EXPECT_EQ(depth.graph.orb_options().features, 321);
  EXPECT_DOUBLE_EQ(depth.graph.level_scales()[1], 1.5);
  EXPECT_EQ(depth.graph.camera().fx, camera.fx);
  EXPECT_EQ(depth.view_options().keyframes, 7);
  EXPECT_EQ(depth.view_options().landmarks, 123);
  options.sensor = "mono";
  const OrbSession mono(options, testing::source_of(camera, CameraKind::depth), {});
  EXPECT_TRUE(mono.mono());
  EXPECT_EQ(mono.graph.baseline(), 0.0);
}

TEST(OrbSession, IsStoppedFromOutside) {
  std::atomic<bool> stop = false;
  SlamContext context;
  const SourceInfo source = testing::source_of(testing::PointWorld(1, 1).camera, CameraKind::mono);
  EXPECT_FALSE(OrbSession({}, source, context).stopped()) << "where nobody can";
  context.stop = &stop;
  const OrbSession session({}, source, context);
  EXPECT_FALSE(session.stopped());
  stop = true;
  EXPECT_TRUE(session.stopped());
}

TEST(OrbSession, RefusesOptionsOutOfRangeAndSensorsNotInTheSource) {
  const Camera camera = testing::PointWorld(1, 1).camera;
  OrbSlamOptions options;
  options.min_inliers = 3;
  EXPECT_THROW(OrbSession(options, testing::source_of(camera, CameraKind::mono), {}), Error);
  options = {};
  options.sensor = "rgbd";
  EXPECT_THROW(OrbSession(options, testing::source_of(camera, CameraKind::mono), {}), Error);
}

}  // namespace
}  // namespace rastro
