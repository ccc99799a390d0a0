// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/rotation_meter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/image/image.h"
#include "rastro/registration/profiles/rotation_chain.h"
#include "rastro/registration/profiles/shift.h"

namespace rastro {
namespace {

constexpr int width = 400, height = 240;

Camera camera() {
  Camera camera = camera_from_field_of_view(60.0, width, height);
  camera.fy = 1.25 * camera.fx;
  return camera;
}

double wave(double position, double phase) {
  return 22.0 * std::sin(0.11 * position + phase) + 17.0 * std::sin(0.047 * position + 2.0 * phase) +
         12.0 * std::sin(0.29 * position + 3.0 * phase);
}

/// Content `right` pixels to the right and `down` pixels below where it is at 0, 0.
GrayImage moved_image(double right, double down) {
  GrayImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(128.0 + wave(x - right, 0.3) + wave(y - down, 1.1)));
  return image;
}

/// Steps are pixels: the image of moved_image() is shifted as a whole.
RotationOptions by_pixels() {
  RotationOptions options;
  options.equal_angles = false;
  return options;
}

TEST(RotationMeter, AShiftOverTheFocalLengthIsTheAngle) {
  for (const char* profile : {"centered", "gradient"}) {
    RotationOptions options = by_pixels();
    options.profile = profile;
    RotationMeter meter(options, camera());
    EXPECT_FALSE(meter.measure(moved_image(0, 0).view())) << "nothing to compare with";
    meter.keep_as_reference();
    const auto rotation = meter.measure(moved_image(12, -5).view());
    ASSERT_TRUE(rotation);
    EXPECT_NEAR(rotation->columns.shift, 12.0, 0.1) << profile;
    EXPECT_NEAR(rotation->yaw, 12.0 / camera().fx, 0.1 / camera().fx) << "to the left, as the content goes right";
    EXPECT_NEAR(rotation->pitch, -5.0 / camera().fy, 0.1 / camera().fy);
    EXPECT_FALSE(rotation->still);
    EXPECT_FALSE(rotation->weak);
  }
}

TEST(RotationMeter, LambdaReplacesTheFocalLengthForYawAlone) {
  RotationOptions options = by_pixels();
  options.lambda = 0.01;
  RotationMeter meter(options, camera());
  meter.measure(moved_image(0, 0).view());
  meter.keep_as_reference();
  const auto rotation = meter.measure(moved_image(-8, 4).view());
  EXPECT_NEAR(rotation->yaw, -0.08, 0.001);
  EXPECT_NEAR(rotation->pitch, 4.0 / camera().fy, 0.1 / camera().fy);
}

TEST(RotationMeter, TheReferenceStaysUntilAnotherOneIsKept) {
  RotationMeter meter(by_pixels(), camera());
  meter.measure(moved_image(0, 0).view());
  meter.keep_as_reference();
  EXPECT_NEAR(meter.measure(moved_image(6, 0).view())->columns.shift, 6.0, 0.1);
  EXPECT_NEAR(meter.measure(moved_image(10, 0).view())->columns.shift, 10.0, 0.1);
  meter.keep_as_reference();
  EXPECT_NEAR(meter.measure(moved_image(13, 0).view())->columns.shift, 3.0, 0.1);
}

TEST(RotationMeter, UpToHalfAPixelItStandsStill) {
  for (const auto& [right, down] : {std::pair{0.0, 0.0}, {0.4, 0.0}, {0.7, 0.0}, {0.0, 0.4}, {0.0, 0.7}}) {
    RotationMeter meter(by_pixels(), camera());
    meter.measure(moved_image(0, 0).view());
    meter.keep_as_reference();
    const auto rotation = meter.measure(moved_image(right, down).view());
    EXPECT_EQ(rotation->still, std::max(right, down) < 0.5) << right << ' ' << down;
  }
}

TEST(RotationMeter, WithoutRowsThereIsNoPitchAndFlatImagesAreWeak) {
  RotationOptions options = by_pixels();
  options.pitch = false;
  RotationMeter meter(options, camera());
  meter.measure(moved_image(0, 0).view());
  meter.keep_as_reference();
  EXPECT_EQ(meter.measure(moved_image(0, 9).view())->pitch, 0.0);
  RotationMeter blind(by_pixels(), camera());
  const GrayImage flat(width, height);
  blind.measure(flat.view());
  blind.keep_as_reference();
  EXPECT_TRUE(blind.measure(flat.view())->weak);
}

TEST(RotationMeter, BandsAndFocalLengthsThatCannotBeAreErrors) {
  RotationOptions options;
  options.band_top = options.band_bottom = 0.4;
  EXPECT_THROW(RotationMeter(options, camera()), Error);
  options = {};
  options.band_left = 0.7;
  EXPECT_THROW(RotationMeter(options, camera()), Error);
  for (double Camera::*const focal : {&Camera::fx, &Camera::fy}) {
    Camera without = camera();
    without.*focal = 0.0;
    EXPECT_THROW(RotationMeter(RotationOptions(), without), Error);
  }
}

TEST(RotationOf, TurnsTheForwardAxisLeftAndUp) {
  const Eigen::Vector3d left = rotation_of(0.3, 0.0) * Eigen::Vector3d::UnitZ();
  EXPECT_LT((left - Eigen::Vector3d(-std::sin(0.3), 0.0, std::cos(0.3))).norm(), 1e-12);
  const Eigen::Vector3d up = rotation_of(0.0, 0.2) * Eigen::Vector3d::UnitZ();
  EXPECT_LT((up - Eigen::Vector3d(0.0, -std::sin(0.2), std::cos(0.2))).norm(), 1e-12);
}

TEST(RotationChain, MeasuresAgainstTheLastFrameAndCountsItsSteps) {
  RotationOptions options = by_pixels();
  options.pitch = false;
  RotationChain chain(options, camera());
  EXPECT_FALSE(chain.step(moved_image(0, 0).view(), 1));
  EXPECT_NEAR(chain.step(moved_image(4, 0).view(), 1)->measured.yaw, 4.0 / camera().fx, 0.1 / camera().fx);
  const auto two = chain.step(moved_image(12, 0).view(), 2);
  EXPECT_TRUE(two->believed);
  const SO3 whole = rotation_of(8.0 / camera().fx, 0.0), half = rotation_of(4.0 / camera().fx, 0.0);
  EXPECT_LT((whole.inverse() * two->reference_from_current).log().norm(), 1e-3);
  EXPECT_LT((half.inverse() * chain.last_rotation()).log().norm(), 1e-3) << "of one frame";
}

TEST(RotationChain, AFrameThatStandsStillLeavesTheReference) {
  RotationOptions options = by_pixels();
  options.pitch = false;
  RotationChain chain(options, camera());
  chain.step(moved_image(0, 0).view(), 1);
  chain.step(moved_image(5, 0).view(), 1);
  const auto still = chain.step(moved_image(5.4, 0).view(), 1);
  EXPECT_TRUE(still->measured.still);
  EXPECT_EQ(still->reference_from_current.log().norm(), 0.0);
  EXPECT_EQ(chain.last_rotation().log().norm(), 0.0);
  EXPECT_NEAR(chain.step(moved_image(5.8, 0).view(), 1)->measured.columns.shift, 0.8, 0.15) << "creeping adds up";
}

TEST(RotationChain, AWeakRotationFarFromTheLastIsNotBelieved) {
  RotationOptions options = by_pixels();
  options.pitch = false;
  options.min_confidence = 1.1;  // everything is weak
  for (const double most_deg : {1.0, 10.0}) {
    options.max_rotation_change_deg = most_deg;
    RotationChain chain(options, camera());
    chain.step(moved_image(0, 0).view(), 1);
    chain.step(moved_image(3, 0).view(), 1);
    const auto step = chain.step(moved_image(23, 0).view(), 1);  // 17 px more: 2.8 degrees
    EXPECT_EQ(step->believed, most_deg > 2.8) << most_deg;
    const double carried = most_deg > 2.8 ? 20.0 : 3.0;
    const SO3 expected = rotation_of(carried / camera().fx, 0.0);
    EXPECT_LT((expected.inverse() * step->reference_from_current).log().norm(), 1e-3) << most_deg;
  }
}

TEST(RotationChain, ASteadyPitchIsTakenForItsBias) {
  RotationOptions options = by_pixels();
  options.pitch_forgetting = 0.5;
  RotationChain chain(options, camera());
  chain.step(moved_image(0, 0).view(), 1);
  double bias = 0.0;
  for (int k = 1; k <= 4; ++k) {
    const auto step = chain.step(moved_image(2.0 * k, 3.0 * k).view(), 1);
    const SO3 expected = rotation_of(2.0 / camera().fx, 3.0 / camera().fy - bias);
    EXPECT_LT((expected.inverse() * step->reference_from_current).log().norm(), 1e-3) << k;
    bias += 0.5 * (3.0 / camera().fy - bias);
  }
}

TEST(LowestOf, IsTheParabolaThroughTheMinimumAndItsNeighbors) {
  const ProfileShift found = lowest_of({9.0, 7.0, 5.0, 4.0, 1.0, 2.0, 6.0, 8.0, 9.0});  // d = -4 .. 4
  EXPECT_NEAR(found.shift, 0.0 + 0.5 * (4.0 - 2.0) / (4.0 - 2.0 + 2.0), 1e-12);
  EXPECT_EQ(found.residual, 1.0);
  EXPECT_EQ(found.at_zero, 1.0);
  EXPECT_NEAR(found.mean, 51.0 / 9.0, 1e-12);
  EXPECT_NEAR(found.sharpness, 4.0 / found.mean, 1e-12);
  EXPECT_NEAR(found.confidence, 1.0 - 1.0 / found.mean, 1e-12) << "no other local minimum is below the mean";
}

TEST(LowestOf, ItsRivalIsAnotherMinimumFartherThanTwoSteps) {
  EXPECT_NEAR(lowest_of({9.0, 3.0, 9.0, 9.0, 1.0, 9.0, 9.0, 9.0, 9.0}).confidence, 1.0 - 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(lowest_of({9.0, 9.0, 3.0, 9.0, 1.0, 9.0, 9.0, 9.0, 9.0}).confidence, 1.0 - 9.0 / 67.0, 1e-12)
      << "a dent two steps away is none: the mean is";
  EXPECT_NEAR(lowest_of({9.0, 9.0, 9.0, 9.0, 1.0, 9.0, 9.0, 9.0, 2.0}).confidence, 0.5, 1e-12) << "at the end";
}

TEST(LowestOf, OfEqualMinimaTheOneNearestToZeroAndNoneAtTheEnds) {
  EXPECT_EQ(lowest_of({5.0, 1.0, 5.0, 5.0, 1.0, 5.0, 5.0}).shift, 1.0);
  EXPECT_EQ(lowest_of({5.0, 1.0, 5.0, 5.0, 5.0, 1.0, 5.0}).shift, -2.0);
  for (const ProfileShift& end : {lowest_of({1.0, 2.0, 3.0, 4.0, 5.0}), lowest_of({5.0, 4.0, 3.0, 2.0, 1.0})}) {
    EXPECT_EQ(std::abs(end.shift), 2.0);
    EXPECT_EQ(end.confidence, 0.0);
    EXPECT_EQ(end.sharpness, 0.0);
  }
  EXPECT_EQ(lowest_of({0.0, 0.0, 0.0}).confidence, 0.0);
}

TEST(FindShift, IsNoneOfNothing) {
  EXPECT_EQ(find_shift({}, {}, 5).confidence, 0.0);
  EXPECT_EQ(find_shift({1}, {1}, 5).shift, 0.0);
}

}  // namespace
}  // namespace rastro
