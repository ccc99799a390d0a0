// SPDX-License-Identifier: Apache-2.0
#include "rastro/input_check/focal_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rastro/base/random.h"
#include "rastro/math/se3.h"

namespace rastro {
namespace {

Camera wide_camera(double focal_factor) {
  Camera camera;
  camera.width = 1240, camera.height = 376;
  camera.fx = camera.fy = 720.0 * focal_factor;
  camera.cx = 620.0, camera.cy = 188.0;
  return camera;
}

/// A drive along a street of points, turning by `yaw_rate` in each of eight frames.
TrackedWindow drive(double yaw_rate, std::uint64_t seed) {
  Random random(seed);
  const Camera camera = wide_camera(1.0);
  TrackedWindow window;
  window.frames = 8;
  for (int i = 0; i < 160; ++i) {
    const Eigen::Vector3d point(20.0 * random.uniform() - 10.0, 3.0 * random.uniform() - 2.0,
                                10.0 + 25.0 * random.uniform());
    std::vector<Eigen::Vector2f> track;
    for (int k = 0; k < 8; ++k) {
      const SE3 world_from_camera(SO3::exp({0.0, yaw_rate * k, 0.0}), {0.1 * yaw_rate * k * k, 0.0, 0.8 * k});
      const Eigen::Vector3d seen = world_from_camera.inverse() * point;
      const Eigen::Vector2d noise(random.normal(), random.normal());
      const Eigen::Vector2d pixel = camera.fx * seen.head<2>() / seen.z() + Eigen::Vector2d(camera.cx, camera.cy);
      track.push_back((pixel + 0.1 * noise).cast<float>());
    }
    window.tracks.push_back(track);
    window.first_depths.push_back(0.0F);
    window.mirrored_depths.push_back(0.0F);
    window.start_depths.push_back(0.0F);
    window.end_depths.push_back(0.0F);
  }
  return window;
}

/// A camera with depth that turns in a room by 6 degrees; one feature in ten has the depth of something else.
TrackedWindow turn_with_depth(double depth_scale, std::uint64_t seed) {
  Random random(seed);
  const Camera camera = wide_camera(1.0);
  const SE3 last_from_first(SO3::exp({0.03, -0.1, 0.02}), {0.05, 0.02, -0.06});
  const auto pixel_of = [&](const Eigen::Vector3d& seen) -> Eigen::Vector2f {
    const Eigen::Vector2d noise(random.normal(), random.normal());
    return (camera.fx * seen.head<2>() / seen.z() + Eigen::Vector2d(camera.cx, camera.cy) + 0.3 * noise).cast<float>();
  };
  const auto depth_of = [&](const Eigen::Vector3d& seen) {
    const double z = seen.z() * (1.0 + 0.005 * random.normal()) * (random.uniform() < 0.1 ? 1.5 : 1.0);
    return static_cast<float>(depth_scale * z);
  };
  TrackedWindow window;
  window.frames = 2;
  for (int i = 0; i < 160; ++i) {
    const double z = 1.0 + 3.0 * random.uniform();
    const Eigen::Vector3d point(z * (1.6 * random.uniform() - 0.8), z * (0.5 * random.uniform() - 0.25), z);
    window.tracks.push_back({pixel_of(point), pixel_of(last_from_first * point)});
    window.first_depths.push_back(depth_of(point));
    window.mirrored_depths.push_back(0.0F);
    window.start_depths.push_back(window.first_depths.back());
    window.end_depths.push_back(depth_of(last_from_first * point));
  }
  return window;
}

TEST(DepthFocal, FindsTheFocalLengthOfOneWindowWhateverTheUnitOfDepth) {
  for (const double given : {0.6, 0.8, 1.0, 1.25, 1.6}) {
    for (const double depth_scale : {1.0, 0.2, 5.0}) {
      const auto fit = focal_from_depth(turn_with_depth(depth_scale, 3), wide_camera(given));
      ASSERT_TRUE(fit) << given;
      EXPECT_NEAR(fit->log_factor, -std::log(given), 0.05) << given << ' ' << depth_scale;
      EXPECT_LT(fit->sigma, 0.03);
    }
  }
}

TEST(DepthFocal, AnInfiniteDepthIsNone) {
  TrackedWindow window = turn_with_depth(1.0, 3);
  window.start_depths[5] = window.end_depths[9] = std::numeric_limits<float>::infinity();
  const auto fit = focal_from_depth(window, wide_camera(0.8));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->log_factor, -std::log(0.8), 0.05);
}

TEST(DepthFocal, NeedsDepthInBothFrames) {
  TrackedWindow window = turn_with_depth(1.0, 3);
  window.end_depths.assign(window.tracks.size(), 0.0F);
  EXPECT_FALSE(focal_from_depth(window, wide_camera(1.0)));
}

/// What another focal length among 0.5, 0.7, 1, 1.4, 2 times it would not tell.
TEST(FocalCheck, TellsByDepthWhatIsOffByFifteenPercentAndNotByFive) {
  for (const double given : {0.85, 1.17, 0.95, 1.0, 1.05}) {
    FocalCheck check(wide_camera(given));
    InputWarnings found;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) check.add(turn_with_depth(1.0, seed), true, found);
    ASSERT_EQ(found.size(), std::abs(given - 1.0) > 0.1 ? 1U : 0U) << given;
    if (!found.empty())
      EXPECT_NE(found.front().text.find("features and depth"), std::string::npos) << found.front().text;
  }
}

TEST(FocalCheck, BlamesNoFocalLengthForDepthThatIsDoubted) {
  FocalCheck check(wide_camera(0.85));
  InputWarnings found;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) check.add(turn_with_depth(1.0, seed), false, found);
  EXPECT_TRUE(found.empty());
}

/// One sigma holds two thirds of the errors; features that err alike are not in this world.
TEST(DepthFocal, ItsSigmaIsThatOfItsErrors) {
  double squares = 0.0;
  constexpr std::uint64_t windows = 40;
  for (std::uint64_t seed = 1; seed <= windows; ++seed) {
    const auto fit = focal_from_depth(turn_with_depth(1.0, seed), wide_camera(0.9));
    ASSERT_TRUE(fit);
    squares += std::pow((fit->log_factor + std::log(0.9)) / fit->sigma, 2.0);
  }
  EXPECT_GT(squares / windows, 0.3);
  EXPECT_LT(squares / windows, 2.0);
}

InputWarnings warnings(double focal_factor, double yaw_rate) {
  FocalCheck check(wide_camera(focal_factor));
  InputWarnings found;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) check.add(drive(yaw_rate, seed), true, found);
  return found;
}

TEST(FocalCheck, TellsAWrongFocalLengthInAGentleTurn) {
  for (const double factor : {0.5, 1.5}) {
    const InputWarnings found = warnings(factor, 0.015);
    ASSERT_EQ(found.size(), 1U) << factor;
    EXPECT_EQ(found.front().kind, "focal_length");
    EXPECT_NE(found.front().text.find(factor < 1.0 ? "longer" : "shorter"), std::string::npos) << found.front().text;
  }
}

TEST(FocalCheck, SaysNothingOfARightOneNorOfAStraightDrive) {
  EXPECT_TRUE(warnings(1.0, 0.015).empty());
  EXPECT_TRUE(warnings(1.0, 0.0).empty());
  EXPECT_TRUE(warnings(0.5, 0.0).empty());
}

}  // namespace
}  // namespace rastro
