// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/rgbd_tracking/surface_matcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/odometry/rgbd_tracking/room_testing.h"

namespace rastro {
namespace {

using testing::matrix_near;
using testing::pose_near;

/// Faces a corner of the room, where three planes constrain the pose.
SE3 corner_pose() { return SE3(SO3::exp({0.45, 0.75, 0.0}), {0.2, -0.2, 0.1}); }

Vector6d small_motion(double x, double y, double z, double rx, double ry, double rz) {
  return (Vector6d() << x, y, z, rx, ry, rz).finished();
}

class SurfaceMatcherTest : public ::testing::Test {
 protected:
  /// Makes a reference of the view from `pose`; depth was taken at `camera_from_depth`.
  void add_reference(const SE3& pose, const SE3& camera_from_depth = {}, const Vector6d& velocity = Vector6d::Zero()) {
    SurfaceMatcher matcher(options_);
    matcher.take(room_.frame(0, pose * camera_from_depth), room_.camera);
    Reference reference;
    reference.world_from_camera = pose;
    matcher.keep(reference, camera_from_depth, velocity);
    map_.references.push_back(reference);
  }
  void take(const SE3& pose) { matcher_.take(room_.frame(1, pose), room_.camera); }

  PaperedRoom room_;
  RgbdOptions options_;
  PointMap map_;
  SurfaceMatcher matcher_{options_};
};

TEST_F(SurfaceMatcherTest, RecoversTheTruePoseFromAPerturbedOne) {
  add_reference(corner_pose());
  const SE3 ground_truth = corner_pose() * SE3::exp(small_motion(0.05, -0.03, 0.04, 0.02, -0.03, 0.02));
  take(ground_truth);
  SE3 pose = ground_truth * SE3::exp(small_motion(-0.02, 0.02, 0.01, 0.01, 0.008, -0.01));
  matcher_.choose(map_, pose, SE3());
  SurfaceMatch match;
  for (int k = 0; k < 10; ++k) {
    match = {};
    const PoseQuadratic sum = matcher_.compare(map_, pose, SE3(), 0.1, 1, &match);
    pose = pose * SE3::exp(sum.information.ldlt().solve(sum.gradient));
  }
  EXPECT_THAT(pose, pose_near(ground_truth, 0.002, 0.001));
  EXPECT_GT(match.compared, 1000);
  EXPECT_GT(match.fitting, match.compared * 9 / 10);
}

/// The camera moved before depth was taken: a known delay does no harm.
TEST_F(SurfaceMatcherTest, DepthOfAnotherInstantIsTransformedToTheColorCamera) {
  const SE3 later = SE3::exp(small_motion(0.03, 0.01, -0.02, 0.02, 0.03, 0.01));
  add_reference(corner_pose(), later);
  const SE3 ground_truth = corner_pose() * SE3::exp(small_motion(0.04, 0.0, 0.03, 0.0, 0.03, 0.0));
  const SE3 later_still = SE3::exp(small_motion(-0.02, 0.02, 0.01, -0.02, 0.01, 0.02));
  take(ground_truth * later_still);
  SE3 pose = ground_truth * SE3::exp(small_motion(0.01, 0.01, -0.01, 0.005, 0.0, 0.005));
  matcher_.choose(map_, pose, later_still);
  for (int k = 0; k < 10; ++k) {
    const PoseQuadratic sum = matcher_.compare(map_, pose, later_still, 0.1, 1);
    pose = pose * SE3::exp(sum.information.ldlt().solve(sum.gradient));
  }
  EXPECT_THAT(pose, pose_near(ground_truth, 0.002, 0.001));
}

TEST_F(SurfaceMatcherTest, WeightsAsItsOptionSaysForAnyStep) {
  add_reference(corner_pose());
  take(corner_pose());
  matcher_.choose(map_, corner_pose(), SE3());
  const PoseQuadratic once = matcher_.compare(map_, corner_pose(), SE3(), 0.1, 1);
  const PoseQuadratic sparse = matcher_.compare(map_, corner_pose(), SE3(), 0.1, 3);
  EXPECT_NEAR(sparse.information.trace() / once.information.trace(), 1.0, 0.1);
  options_.surface_weight *= 3.0;
  const PoseQuadratic thrice = matcher_.compare(map_, corner_pose(), SE3(), 0.1, 1);
  EXPECT_THAT(thrice.information, matrix_near(Matrix6d(3.0 * once.information), 1e-6 * once.information.norm()));
}

TEST_F(SurfaceMatcherTest, TheReferenceWithTheLargestOverlapAndTheOldestGoodOneAreChosen) {
  // Rotated by 40, 8 and 0 degrees from the frame; the overlap of the first is too small to count.
  for (const double yaw : {0.7, 0.14, 0.0})
    add_reference(corner_pose() * SE3(SO3::exp({0.0, yaw, 0.0}), Eigen::Vector3d::Zero()));
  take(corner_pose());
  matcher_.choose(map_, corner_pose(), SE3());
  SurfaceMatch both, best;
  matcher_.compare(map_, corner_pose(), SE3(), 0.1, 1, &both);
  PointMap only_last = map_;
  only_last.first_live = 2;
  matcher_.choose(only_last, corner_pose(), SE3());
  matcher_.compare(only_last, corner_pose(), SE3(), 0.1, 1, &best);
  EXPECT_GT(best.compared, 1000);
  EXPECT_GT(both.compared, best.compared * 3 / 2) << "two references";
  EXPECT_LT(both.compared, best.compared * 2) << "of which the older overlaps less";
  matcher_.choose(map_, SE3(SO3::exp({0.0, M_PI, 0.0}), Eigen::Vector3d::Zero()) * corner_pose(), SE3());
  SurfaceMatch none;
  matcher_.compare(map_, corner_pose(), SE3(), 0.1, 1, &none);
  EXPECT_EQ(none.compared, 0) << "it sees no known surface";
}

TEST_F(SurfaceMatcherTest, WithoutUsableDepthThereAreNoSurfaces) {
  Frame frame = room_.frame(1, corner_pose());
  frame.depth = DepthImage(160, 120);
  matcher_.take(frame, room_.camera);
  EXPECT_FALSE(matcher_.has_surfaces()) << "of another size";
  frame.depth = {};
  matcher_.take(frame, room_.camera);
  EXPECT_FALSE(matcher_.has_surfaces());
  take(corner_pose());
  EXPECT_TRUE(matcher_.has_surfaces());
  options_.surfaces = "off";
  take(corner_pose());
  EXPECT_FALSE(matcher_.has_surfaces());
  Reference reference;
  matcher_.keep(reference, SE3(), Vector6d::Ones());
  EXPECT_TRUE(reference.planes.empty());
  EXPECT_EQ(reference.velocity, Vector6d::Ones());
}

/// The camera moves fast, and depth was taken later than its stamp says; the reference was taken at rest.
TEST_F(SurfaceMatcherTest, EstimatesTheDelayOfDepth) {
  constexpr double delay = 0.02;
  const Vector6d velocity = small_motion(0.4, -0.3, 0.5, 0.4, -0.5, 0.3);
  add_reference(corner_pose());
  const SE3 ground_truth = corner_pose() * SE3::exp(small_motion(0.02, 0.01, 0.02, 0.01, 0.01, 0.0));
  take(ground_truth * SE3::exp(delay * velocity));
  matcher_.choose(map_, ground_truth, SE3());
  double found = 0.0;
  for (int k = 0; k < 8; ++k) {
    const SE3 camera_from_depth = SE3::exp(found * velocity);
    const DelayedQuadratic sum = matcher_.compare_with_delay(map_, ground_truth, camera_from_depth, velocity, 0.1, 1);
    EXPECT_THAT(Matrix6d(sum.information.topLeftCorner<6, 6>()),
                matrix_near(matcher_.compare(map_, ground_truth, camera_from_depth, 0.1, 1).information,
                            1e-9 * sum.information.norm()));
    found += sum.gradient(6) / sum.information(6, 6);  // the pose is known
  }
  EXPECT_NEAR(found, delay, 0.001);
}

TEST_F(SurfaceMatcherTest, AReferenceWithTheSameMotionHidesTheDelay) {
  const Vector6d velocity = small_motion(0.4, -0.3, 0.5, 0.4, -0.5, 0.3);
  add_reference(corner_pose(), SE3(), velocity);
  take(corner_pose());
  matcher_.choose(map_, corner_pose(), SE3());
  const DelayedQuadratic sum = matcher_.compare_with_delay(map_, corner_pose(), SE3(), velocity, 0.1, 1);
  EXPECT_NEAR(sum.information(6, 6), 0.0, 1e-9 * sum.information.norm());
}

}  // namespace
}  // namespace rastro
