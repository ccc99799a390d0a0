// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/ground_scale.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "rastro/odometry/scale.h"

namespace rastro {
namespace {

constexpr double camera_height_m = 1.65;

Camera car_camera() {
  Camera camera;
  camera.width = 400;
  camera.height = 140;
  camera.fx = camera.fy = 240.0;
  camera.cx = 199.5;
  camera.cy = 60.0;
  return camera;
}

/// A road with smooth random texture of all scales.
double road_gray(double x, double z) {
  double gray = 110.0;
  for (int i = 1; i <= 6; ++i) {
    gray += 14.0 * std::sin(0.9 * i * x + 1.7 * i) * std::cos(0.7 * i * z - 0.4 * i * x);
  }
  return gray;
}

/// Image of a camera above the road, pitched down by `pitch`.
GrayImage render(const Camera& camera, double ahead_m, double pitch) {
  GrayImage image(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = camera.unproject({static_cast<double>(x), static_cast<double>(y)})->homogeneous();
      const double down = std::cos(pitch) * ray.y() + std::sin(pitch) * ray.z();
      const double forward = -std::sin(pitch) * ray.y() + std::cos(pitch) * ray.z();
      const double distance = down > 0.02 ? camera_height_m / down : 0.0;
      const double gray = distance > 0.0 ? road_gray(ray.x() * distance, forward * distance + ahead_m) : 200.0;
      image.at(x, y) = static_cast<std::uint8_t>(std::clamp(gray, 0.0, 255.0));
    }
  }
  return image;
}

/// Images and exact poses at these positions along the road, plus `noise_m` up and down.
std::optional<GroundScale::Found> drive_along(const std::vector<double>& ahead_m, double noise_m = 0.0) {
  const Camera camera = car_camera();
  GroundScale scale(camera, camera_height_m);
  for (std::size_t i = 0; i < ahead_m.size(); ++i) {
    const double up_m = i % 2 == 0 ? 0.0 : noise_m;
    scale.add(render(camera, ahead_m[i], 0.0).view(), SE3(SO3(), {0.0, -up_m, ahead_m[i]}));
  }
  return scale.find();
}

/// Positions at `speeds_m` per frame, `frames` frames each.
std::vector<double> positions(const std::vector<double>& speeds_m, int frames) {
  std::vector<double> ahead_m{0.0};
  for (const double speed_m : speeds_m)
    for (int i = 0; i < frames; ++i) ahead_m.push_back(ahead_m.back() + speed_m);
  return ahead_m;
}

/// Poses in units of `meters_per_unit`.
std::optional<GroundScale::Found> drive(double meters_per_unit, double pitch, int frames, double step_m) {
  const Camera camera = car_camera();
  GroundScale scale(camera, camera_height_m);
  for (int i = 0; i < frames; ++i) {
    const Eigen::Vector3d ahead(0.0, -std::sin(pitch), std::cos(pitch));
    scale.add(render(camera, i * step_m, pitch).view(), SE3(SO3(), i * step_m / meters_per_unit * ahead));
  }
  return scale.find();
}

TEST(GroundScale, FindsTheMetersPerUnit) {
  for (const double meters_per_unit : {0.3, 1.0, 7.5}) {
    for (const double pitch : {0.0, 0.03}) {
      const auto found = drive(meters_per_unit, pitch, 14, 0.7);
      ASSERT_TRUE(found) << meters_per_unit << ' ' << pitch;
      EXPECT_NEAR(found->meters_per_unit / meters_per_unit, 1.0, 0.01) << meters_per_unit << ' ' << pitch;
      EXPECT_NEAR(found->pitch_rad, pitch, 1e-6);
      EXPECT_LT(found->relative_sigma, 0.02);
    }
  }
}

TEST(GroundScale, ACarMayDriveBackward) {
  for (const double pitch : {0.0, 0.03}) {
    const auto found = drive(1.0, pitch, 14, -0.7);
    ASSERT_TRUE(found) << pitch;
    EXPECT_NEAR(found->meters_per_unit, 1.0, 0.01) << pitch;
    EXPECT_NEAR(found->pitch_rad, pitch, 1e-6);
  }
}

TEST(GroundScale, ShortStepsGiveTheScaleToo) {
  // 12 km/h at 30 frames a second; 15 km/h, then 50; stop and go at 10 frames a second.
  const std::vector<std::vector<double>> drives = {
      {0.11}, {0.14, 0.14, 0.14, 0.46, 0.46}, {0.14, 0.7, 0.14, 0.05, 0.14, 0.14}};
  for (const std::vector<double>& speeds_m : drives) {
    const auto found = drive_along(positions(speeds_m, speeds_m.size() == 1 ? 14 : 5));
    ASSERT_TRUE(found) << speeds_m.size();
    EXPECT_NEAR(found->meters_per_unit, 1.0, 0.01) << speeds_m.size();
  }
}

TEST(GroundScale, NoiseOfACameraThatWaitsIsNoDirection) {
  const auto found = drive_along(positions({0.7, 0.0, 0.7, 0.0}, 10), 0.004);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->meters_per_unit, 1.0, 0.02);
  EXPECT_NEAR(found->pitch_rad, 0.0, 0.01);
}

TEST(GroundScale, GivesNothingWithoutMotionOrWithFewFrames) {
  EXPECT_FALSE(drive(1.0, 0.0, 14, 0.0));
  EXPECT_FALSE(drive(1.0, 0.0, 5, 0.7));
  GroundScale scale(car_camera(), camera_height_m);
  const GrayImage blank(400, 140);
  for (int i = 0; i < 20; ++i) scale.add(blank.view(), SE3(SO3(), {0.0, 0.0, 0.5 * i}));
  scale.add(GrayView{}, SE3());
  EXPECT_FALSE(scale.find());
}

TEST(ScaleFromReference, IsThatOfTheSimilarity) {
  Trajectory ours, theirs;
  for (int i = 0; i < 10; ++i) {
    const SE3 pose(SO3::exp({0.0, 0.05 * i, 0.0}), {0.3 * i, 0.1 * std::sin(i), 0.02 * i * i});
    ours.push_back({i * 100'000'000LL, pose});
    theirs.push_back({i * 100'000'000LL, SE3(pose.rotation(), 4.0 * pose.translation())});
  }
  EXPECT_NEAR(*scale_from_reference(ours, theirs), 4.0, 1e-9);
  const double length = path_length(ours);
  scale_trajectory(ours, 4.0);
  EXPECT_NEAR(path_length(ours), 4.0 * length, 1e-9);
  EXPECT_FALSE(scale_from_reference({}, theirs));
}

}  // namespace
}  // namespace rastro
