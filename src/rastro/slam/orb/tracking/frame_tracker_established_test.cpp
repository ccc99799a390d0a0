// SPDX-License-Identifier: Apache-2.0
// A crowd that walks along with the camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::PointWorld;
using testing::pose_near;

SE3 along_street(double x) { return SE3(SO3(), {-x, 0.0, 0.0}); }

/// Three keyframes saw the houses, the last one a crowd too, which goes on by `walked_m`.
struct Crowd {
  static constexpr std::uint32_t houses = 150, all = 400;

  explicit Crowd(CameraKind sensor, OrbSlamOptions options = {})
      : baseline(sensor == CameraKind::mono ? 0.0 : 0.1),
        world(all, 5),
        map(world, sensor, baseline),
        tracker(options, world.camera, sensor, baseline) {
    map.add(0, along_street(0.0), {.to = houses});
    map.add(1, along_street(0.1), {.to = houses});
    map.add(2, along_street(0.2));
    tracker.set_view(view_of(map.graph, 2, {}));
  }
  TrackingResult track_after(double walked_m) {
    for (std::uint32_t i = houses; i < all; ++i) world.points[i].x() += walked_m;
    return tracker.track_from(world.observe(7, here, {.baseline = baseline}).frame, here);
  }

  double baseline;
  SE3 here = along_street(0.25);
  PointWorld world;
  ExactMap map;
  FrameTracker tracker;
};

class EstablishedLandmarks : public ::testing::TestWithParam<CameraKind> {};

TEST_P(EstablishedLandmarks, GiveThePoseWhereACrowdOfNewOnesMoves) {
  Crowd crowd(GetParam());
  const TrackingResult result = crowd.track_after(0.1);
  ASSERT_TRUE(result.ok);
  EXPECT_THAT(result.camera_from_world, pose_near(crowd.here, 1e-3, 1e-4));
  EXPECT_LT(result.inliers, 200) << "the crowd";
  EXPECT_GT(result.outliers.size(), 150U);
}

TEST_P(EstablishedLandmarks, TheCrowdTakesAlongWhoDoesNotAskThem) {
  OrbSlamOptions options;
  options.established_inliers = 1000;
  Crowd crowd(GetParam(), options);
  const SE3 error = crowd.track_after(0.1).camera_from_world * crowd.here.inverse();
  EXPECT_GT(error.translation().norm(), 0.05);
}

TEST_P(EstablishedLandmarks, WhereAllAgreeAllCount) {
  Crowd crowd(GetParam());
  const TrackingResult result = crowd.track_after(0.0);
  ASSERT_TRUE(result.ok);
  EXPECT_GT(result.inliers, 350);
}

INSTANTIATE_TEST_SUITE_P(Sensors, EstablishedLandmarks, ::testing::Values(CameraKind::mono, CameraKind::depth));

}  // namespace
}  // namespace rastro
