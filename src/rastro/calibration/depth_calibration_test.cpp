// SPDX-License-Identifier: Apache-2.0
// Generated boards in front of a depth camera whose errors are known.
#include "rastro/calibration/depth_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "rastro/base/error.h"
#include "rastro/base/random.h"
#include "rastro/calibration/board.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

const Camera depth_camera{320, 240, 262.0, 262.0, 159.5, 119.5};
const Board board{9, 6, 0.06};

struct DepthErrors {
  double scale = 1.0, offset_m = 0.0;  ///< Of the correction: true = scale * depth + offset.
  double sigma_m = 0.001, sigma_per_m2 = 0.002;
  SE3 color_from_depth;
};

/// Depth of a board before a wall.
DepthImage depth_of(const SE3& color_from_board, const DepthErrors& errors, Random& random) {
  const SE3 board_from_depth = color_from_board.inverse() * errors.color_from_depth;
  DepthImage image(depth_camera.width, depth_camera.height);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const auto flat = depth_camera.unproject({static_cast<double>(x), static_cast<double>(y)});
      const Eigen::Vector3d ray = board_from_depth.rotation() * Eigen::Vector3d(flat->x(), flat->y(), 1.0);
      const Eigen::Vector3d origin = board_from_depth.translation();
      double z = -origin.z() / ray.z();
      const Eigen::Vector3d hit = origin + z * ray;
      const bool on_board = z > 0.1 && hit.x() > -0.06 && hit.y() > -0.06 && hit.x() < 0.54 && hit.y() < 0.36;
      if (!on_board) z = 4.0;
      z += (errors.sigma_m + errors.sigma_per_m2 * z * z) * random.normal();
      image.at(x, y) = static_cast<float>((z - errors.offset_m) / errors.scale);
    }
  return image;
}

struct Recorded {
  std::vector<DepthImage> images;
  DepthCalibrationInput input;
};

Recorded record(const DepthErrors& errors, int views, double nearest, double farthest) {
  Recorded made;
  Random random(3);
  made.input.depth_camera = depth_camera;
  made.input.low = {0.0, 0.0};
  made.input.high = board.points().back();
  std::vector<SE3> poses;
  for (int k = 0; k < views; ++k) {
    const auto angle = [&](double degrees) { return random.uniform(-degrees, degrees) * std::numbers::pi / 180.0; };
    const SO3 rotation = SO3::exp({angle(35.0), angle(35.0), angle(20.0)});
    const double z = nearest + (farthest - nearest) * k / std::max(1, views - 1);
    const Eigen::Vector3d center(random.uniform(-0.2, 0.2) * z, random.uniform(-0.15, 0.15) * z, z);
    const Eigen::Vector2d middle = 0.5 * board.points().back();
    poses.emplace_back(rotation, center - rotation * Eigen::Vector3d(middle.x(), middle.y(), 0.0));
    made.images.push_back(depth_of(poses.back(), errors, random));
  }
  for (std::size_t k = 0; k < poses.size(); ++k) made.input.views.push_back({poses[k], &made.images[k]});
  return made;
}

TEST(DepthCalibrationTest, ScaleOffsetAndNoiseAreWithinTheirSigmas) {
  DepthErrors errors;
  errors.scale = 1.02;
  errors.offset_m = -0.008;
  const Recorded made = record(errors, 20, 0.6, 2.0);
  const DepthCalibration found = calibrate_depth(made.input);
  EXPECT_EQ(found.views, 20);
  EXPECT_LT(std::abs(found.scale - 1.02), 4.0 * found.scale_sigma);
  EXPECT_LT(std::abs(found.offset_m + 0.008), 4.0 * found.offset_sigma_m);
  EXPECT_LT(found.scale_sigma, 0.001);
  EXPECT_LT(found.offset_sigma_m, 0.001);
  EXPECT_NEAR(found.sigma_m, 0.001, 0.0004);
  EXPECT_NEAR(found.sigma_per_m2, 0.002, 0.0003);
  EXPECT_THAT(found.doubts, Contains(HasSubstr("too small")));
  EXPECT_THAT(found.doubts, Not(Contains(HasSubstr("registered"))));
  EXPECT_THAT(depth_calibration_text(found, {5000.0, 0.0, {}}), HasSubstr("depth_factor: 490"));
}

TEST(DepthCalibrationTest, WhatCorrectsCorrectedDepthCorrectsTheRawReadings) {
  DepthCalibration found;
  found.scale = 1.25;
  found.offset_m = -0.01;
  // Read as raw / 800 + 0.02; right is 1.25 * that - 0.01 = raw / 640 + 0.015.
  const std::string text = depth_calibration_text(found, {800.0, 0.02, {}});
  EXPECT_THAT(text, HasSubstr("depth_factor: 640\n"));
  EXPECT_THAT(text, HasSubstr("depth_offset_m: 0.015\n"));
}

TEST(DepthCalibrationTest, WhatPutTheDepthIntoColorIsKept) {
  DepthAsRead read{1000.0, 0.0, {}};
  EXPECT_THAT(depth_calibration_text({}, read), Not(HasSubstr("color_from_depth")));
  read.registration = {{160, 120, 140.0, 140.0, 79.5, 59.5}, SE3(SO3(), {0.05, 0.0, 0.0})};
  EXPECT_THAT(depth_calibration_text({}, read), AllOf(HasSubstr("depth_camera"), HasSubstr("color_from_depth")));
}

TEST(DepthCalibrationTest, DepthThatIsNotRegisteredIsNamedAndItsPoseIsFound) {
  DepthErrors errors;
  errors.color_from_depth = SE3(SO3::exp({0.01, -0.015, 0.005}), {0.025, -0.002, 0.004});
  Recorded made = record(errors, 20, 0.6, 2.0);
  EXPECT_THAT(calibrate_depth(made.input).doubts, Contains(HasSubstr("not registered")));
  made.input.registered = false;
  const DepthCalibration found = calibrate_depth(made.input);
  const SE3 off = found.color_from_depth * errors.color_from_depth.inverse();
  EXPECT_LT(off.rotation().log().lpNorm<Eigen::Infinity>(), 4.0 * found.rotation_sigma_rad);
  EXPECT_LT(off.translation().lpNorm<Eigen::Infinity>(), 4.0 * found.translation_sigma_m);
  EXPECT_LT(found.translation_sigma_m, 0.003);
  EXPECT_LT(std::abs(found.scale - 1.0), 4.0 * found.scale_sigma);
}

TEST(DepthCalibrationTest, TooLittleIsAnErrorOfOneLine) {
  const Recorded few = record({}, 2, 0.6, 2.0);
  EXPECT_THROW(calibrate_depth(few.input), Error);
  const Recorded near = record({}, 8, 0.8, 0.82);
  EXPECT_THROW(calibrate_depth(near.input), Error);
  DepthCalibrationInput none;
  EXPECT_THROW(calibrate_depth(none), Error);
}

}  // namespace
}  // namespace rastro
