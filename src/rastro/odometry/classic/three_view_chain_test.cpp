// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/classic/three_view_chain.h"

#include <gtest/gtest.h>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr double focal_px = 700.0;

/// A camera that drives through points without noise.
class PointWorld {
 public:
  PointWorld() {
    Random random(3);
    for (int k = 0; k < 1500; ++k) {
      const double x = random.uniform(-12.0, 12.0), y = random.uniform(-4.0, 4.0), z = random.uniform(2.0, 45.0);
      points_.emplace_back(x, y, z);
    }
  }

  RayObservations observed_from(const SE3& world_from_camera) const {
    RayObservations observations;
    const SE3 camera_from_world = world_from_camera.inverse();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Eigen::Vector3d p = camera_from_world * points_[k];
      if (p.z() < 1.0 || p.z() > 25.0) continue;
      const Eigen::Vector2d ray = p.hnormalized();
      if (std::abs(ray.x()) < 0.8 && std::abs(ray.y()) < 0.3) observations.push_back({static_cast<int>(k), ray});
    }
    return observations;
  }

 private:
  std::vector<Eigen::Vector3d> points_;
};

/// Steps of several lengths around bends; the first has length 1.
std::vector<SE3> path(int frames) {
  std::vector<SE3> poses = {SE3()};
  for (int k = 1; k < frames; ++k) {
    const double length = k == 1 ? 1.0 : 0.7 + 0.5 * std::sin(1.7 * k);
    const SO3 bend = SO3::exp({0.004 * std::cos(k), 0.03 * std::sin(0.5 * k), 0.003});
    poses.push_back(poses.back() * SE3(bend, length * Eigen::Vector3d(0.05 * std::sin(k), 0.02, 1.0).normalized()));
  }
  return poses;
}

OdometryUpdate add(ThreeViewChain& chain, RayObservations observations) {
  OdometryUpdate update;
  chain.add(std::move(observations), update);
  return update;
}

void expect_near(const SE3& pose, const SE3& expected, double tolerance) {
  EXPECT_LT((pose.translation() - expected.translation()).norm(), tolerance);
  EXPECT_LT((pose.rotation().inverse() * expected.rotation()).log().norm(), tolerance);
}

TEST(ThreeViewChain, CarriesTheScaleOfTheFirstPairAlong) {
  const PointWorld world;
  const ClassicOptions options;
  ThreeViewChain chain(options, focal_px);
  const std::vector<SE3> poses = path(25);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const OdometryUpdate update = add(chain, world.observed_from(poses[k]));
    EXPECT_EQ(update.state, k == 0 ? OdometryState::initializing : OdometryState::tracking) << k;
    EXPECT_EQ(update.inliers, update.matches) << k;
    expect_near(update.world_from_camera, poses[k], 1e-6);
    expect_near(chain.trajectory()[k].world_from_body, poses[k], 1e-6);
  }
}

TEST(ThreeViewChain, WrongMatchesAreOutliers) {
  const PointWorld world;
  const ClassicOptions options;
  ThreeViewChain chain(options, focal_px);
  Random random(5);
  const std::vector<SE3> poses = path(8);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    RayObservations observations = world.observed_from(poses[k]);
    for (RayObservation& observation : observations)
      if (random.uniform() < 0.1) observation.ray = {random.uniform(-0.8, 0.8), random.uniform(-0.3, 0.3)};
    const OdometryUpdate update = add(chain, observations);
    if (k > 0) EXPECT_EQ(update.state, OdometryState::tracking) << k;
    if (k > 1) EXPECT_LT(update.confidence, 0.95) << k;
    // A wrong match near the right pixel counts as right.
    expect_near(update.world_from_camera, poses[k], 0.02);
  }
}

TEST(ThreeViewChain, RestAndRotationOnTheSpotAreSaid) {
  const PointWorld world;
  const ClassicOptions options;
  ThreeViewChain chain(options, focal_px);
  const SE3 turned(SO3::exp({0.0, 0.05, 0.0}), Eigen::Vector3d::Zero());
  const std::vector<SE3> poses = path(6);
  add(chain, world.observed_from(poses[0]));
  EXPECT_EQ(add(chain, world.observed_from(poses[0])).reason, OdometryReason::no_motion);
  const OdometryUpdate early = add(chain, world.observed_from(turned));
  EXPECT_EQ(early.state, OdometryState::initializing);
  EXPECT_EQ(early.reason, OdometryReason::pure_rotation);
  expect_near(early.world_from_camera, turned, 1e-6);
  for (int k = 1; k < 6; ++k) add(chain, world.observed_from(poses[k]));
  expect_near(chain.trajectory().back().world_from_body, poses[5], 1e-6);
  const OdometryUpdate still = add(chain, world.observed_from(poses[5]));
  EXPECT_EQ(still.state, OdometryState::tracking);
  EXPECT_EQ(still.reason, OdometryReason::no_motion);
  expect_near(still.world_from_camera, poses[5], 1e-6);
  // The points of the pair before place a camera that only rotates, too.
  const OdometryUpdate later = add(chain, world.observed_from(poses[5] * turned));
  EXPECT_EQ(later.state, OdometryState::tracking);
  EXPECT_EQ(later.reason, OdometryReason::too_little_parallax);
  expect_near(later.world_from_camera, poses[5] * turned, 1e-6);
}

TEST(ThreeViewChain, GoesOnAfterALossWithTheLastLength) {
  const PointWorld world;
  const ClassicOptions options;
  ThreeViewChain chain(options, focal_px);
  std::vector<SE3> poses;
  for (int k = 0; k < 12; ++k) poses.emplace_back(SO3(), Eigen::Vector3d(0.0, 0.0, k));
  for (int k = 0; k < 4; ++k) add(chain, world.observed_from(poses[k]));
  const OdometryUpdate blind = add(chain, {});
  EXPECT_EQ(blind.state, OdometryState::lost);
  EXPECT_EQ(blind.reason, OdometryReason::too_few_points);
  expect_near(blind.world_from_camera, poses[4], 1e-6);  // the last motion again
  EXPECT_EQ(add(chain, world.observed_from(poses[5])).state, OdometryState::lost);
  const OdometryUpdate weak = add(chain, world.observed_from(poses[6]));
  EXPECT_EQ(weak.state, OdometryState::weak);
  EXPECT_EQ(weak.reason, OdometryReason::few_inliers);
  const OdometryUpdate again = add(chain, world.observed_from(poses[7]));
  EXPECT_EQ(again.state, OdometryState::tracking);
  expect_near(again.world_from_camera, poses[7], 1e-6);
}

TEST(ThreeViewChain, FramesWithoutInformationRepeatTheLastMotionForAWhile) {
  const PointWorld world;
  ClassicOptions options;
  options.max_bridged_frames = 2;
  ThreeViewChain chain(options, focal_px);
  std::vector<SE3> poses;
  for (int k = 0; k < 12; ++k) poses.emplace_back(SO3(), Eigen::Vector3d(0.0, 0.0, k));
  for (int k = 0; k < 3; ++k) add(chain, world.observed_from(poses[k]));
  for (int k = 3; k < 6; ++k) {
    OdometryUpdate update;
    update.reason = OdometryReason::dark_or_blank;
    chain.bridge(update);
    EXPECT_FALSE(update.used);
    EXPECT_EQ(update.state, k < 5 ? OdometryState::weak : OdometryState::lost);
    expect_near(update.world_from_camera, poses[std::min(k, 4)], 1e-6);
  }
  expect_near(add(chain, world.observed_from(poses[6])).world_from_camera, poses[6], 1e-6);
}

}  // namespace
}  // namespace rastro
