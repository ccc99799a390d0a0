// SPDX-License-Identifier: Apache-2.0
// A place that EKF-SLAM comes back to after a long way.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/slam/ekf/ekf_slam.h"

namespace rastro {
namespace {

const std::vector<Eigen::Vector2d> furniture = {{4.0, 1.0}, {5.5, -1.5}, {6.0, 2.0},
                                                {7.0, 0.5}, {3.0, -2.5}, {2.5, 2.2}};

EkfOptions options_with(int observations) {
  EkfOptions options;
  options.observations = observations;
  options.odometry_error_m_per_m = 0.1;
  options.range_noise_m = 0.01;
  options.range_noise_share = 0.0;
  options.bearing_noise_deg = 0.1;
  return options;
}

/// A robot that looks at furniture, drives 10 m ahead and back, and looks again; odometry is wrong by `drift` then.
class WayBack {
 public:
  explicit WayBack(int observations) : slam(options_with(observations), false) {
    for (int k = 0; k < 8; ++k) go(0.001 * k, SE2(), true);
    for (int k = 1; k <= 50; ++k) go(0.4 * (k <= 25 ? k : 50 - k), SE2(), false);
  }
  /// Until the place is recognized, in 8 frames at most; how many it took.
  int look_again() {
    for (int k = 1; k <= 8; ++k) {
      for (const SlamEvent& event : go(0.001 * k, drift, true).events)
        if (event.kind == "loop_closed") return k;
    }
    return -1;
  }
  SlamUpdate go(double odometry_x, const SE2& world_from_odometry, bool sees) {
    const SE2 told(SO2(), {odometry_x, 0.0});
    Frame frame;
    frame.index = frames_;
    frame.stamp = 100'000'000 * ++frames_;
    frame.odometry_from_body = told;
    true_ = world_from_odometry * told;
    for (const Eigen::Vector2d& point : furniture) {
      const Eigen::Vector2d seen = true_.inverse() * point;
      if (sees) frame.landmarks.push_back({-1, seen.norm(), std::atan2(seen.y(), seen.x())});
    }
    return slam.process(frame);
  }
  double error_m() const { return (slam.filter().world_from_body().translation() - true_.translation()).norm(); }
  LandmarkLayer landmarks() const { return *slam.snapshot()->layer<LandmarkLayer>(); }

  EkfSlam slam;

 private:
  const SE2 drift{SO2::from_angle(0.03), {0.3, -0.2}};
  std::int64_t frames_ = 0;
  SE2 true_;
};

TEST(EkfPlace, IsRecognizedByLandmarksThatWereObservedOftenEnough) {
  for (const int observations : {5, 2, 1}) {
    WayBack way(observations);
    EXPECT_EQ(way.landmarks().landmarks.size(), furniture.size());
    EXPECT_EQ(way.look_again(), observations) << observations;
    EXPECT_LT(way.error_m(), 0.05) << observations;
    EXPECT_EQ(way.landmarks().landmarks.size(), furniture.size()) << "united";
    EXPECT_EQ(way.slam.filter().landmarks(), furniture.size());
  }
}

TEST(EkfPlace, ObservationsHaveTheIdsOfTheUnitedLandmarks) {
  for (const int observations : {5, 1}) {
    WayBack way(observations);
    ASSERT_GT(way.look_again(), 0);
    const LandmarkLayer known = way.landmarks();
    const auto seen = way.slam.observations();
    ASSERT_EQ(seen.size(), furniture.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_EQ(seen[i].landmark, static_cast<std::int64_t>(i));
      EXPECT_TRUE(known.find(seen[i].landmark)) << i;
    }
    EXPECT_EQ(way.go(0.01, SE2(SO2::from_angle(0.03), {0.3, -0.2}), true).used, 6);
  }
}

TEST(EkfPlace, IsRecognizedWithoutMappingAndNothingIsAdded) {
  WayBack way(5);
  way.slam.set_mapping(false);
  const auto before = way.landmarks().landmarks;
  EXPECT_EQ(way.look_again(), 5);
  EXPECT_LT(way.error_m(), 0.05);
  const auto after = way.landmarks().landmarks;
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i].id, before[i].id);
  EXPECT_EQ(way.slam.filter().landmarks(), furniture.size()) << "no candidate is left";
  for (const FeatureObservation& seen : way.slam.observations()) EXPECT_EQ(seen.landmark, -1) << "of candidates";
}

}  // namespace
}  // namespace rastro
