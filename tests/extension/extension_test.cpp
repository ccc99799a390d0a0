// SPDX-License-Identifier: Apache-2.0
// Methods that nothing in src/rastro names are listed, set and run like its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/map/graph/map.h"
#include "rastro/methods/methods.h"
#include "rastro/session/fakes_testing.h"
#include "rastro/session/odometry_run.h"
#include "rastro/session/slam_run.h"

namespace rastro {
namespace {

template <typename Method>
std::vector<std::string> names_of(const std::vector<std::unique_ptr<Method>>& methods) {
  std::vector<std::string> names;
  for (const auto& method : methods) names.push_back(method->name());
  return names;
}

TEST(Extension, MethodsFromElsewhereStandBesideRastrosOwn) {
  const std::vector<std::string> odometries = names_of(odometry_methods()), slams = names_of(slam_methods());
  EXPECT_THAT(odometries, testing::IsSupersetOf({"features", "still"}));
  EXPECT_THAT(slams, testing::IsSupersetOf({"hector", "still"}));
  EXPECT_TRUE(std::is_sorted(odometries.begin(), odometries.end()));
  EXPECT_TRUE(std::is_sorted(slams.begin(), slams.end()));
}

TEST(Extension, ANameNearlyRightLeadsToThem) {
  const auto did_you_mean_still = testing::ThrowsMessage<Error>(testing::HasSubstr("did you mean 'still'"));
  EXPECT_THAT([] { odometry_method("stil"); }, did_you_mean_still);
  EXPECT_THAT([] { slam_method("stlil"); }, did_you_mean_still);
}

/// Every frame of the fake source with a pose at this height.
void expect_still_at(const Trajectory& trajectory, double height_m) {
  ASSERT_EQ(trajectory.size(), 5U);
  for (const StampedPose& pose : trajectory)
    EXPECT_EQ(pose.world_from_body.translation(), Eigen::Vector3d(0.0, 0.0, height_m));
}

TEST(Extension, AnOdometryRuns) {
  const auto method = odometry_method("still");
  method->options().set_assignment("height_m=2.5", "a test");
  FakeSource source(5);
  const auto odometry = method->make(source.info(), {});
  OdometryRun run;
  run.source = &source;
  run.method = odometry.get();
  const OdometryRunEnd end = odometry_run(run);
  EXPECT_EQ(end.result.tracking, 5);
  EXPECT_EQ(end.result.ended, "end of data");
  expect_still_at(end.trajectory, 2.5);
}

TEST(Extension, ASlamMethodRuns) {
  const auto method = slam_method("still");
  method->options().set_assignment("height_m=0.25", "a test");
  FakeSource source(5);
  const auto slam = method->make(source.info(), {});
  SlamRun run;
  run.source = &source;
  run.method = slam.get();
  const SlamRunEnd end = slam_run(run);
  EXPECT_EQ(end.result.states.tracking, 5);
  EXPECT_EQ(end.result.ended, "end of data");
  expect_still_at(end.trajectory, 0.25);
  ASSERT_NE(end.map, nullptr);
  EXPECT_EQ(contradiction_in(*end.map), "");
  EXPECT_EQ(end.map->keyframes.size(), 1U);
  expect_still_at(trajectory_of(*end.map), 0.25);
}

}  // namespace
}  // namespace rastro
