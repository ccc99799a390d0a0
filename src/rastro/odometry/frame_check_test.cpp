// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/frame_check.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/image/image_testing.h"

namespace rastro {
namespace {

using testing::wave_image;

constexpr TimeNs step = 100'000'000;

GrayImage flat_image(std::uint8_t gray) {
  GrayImage image(160, 120);
  for (int y = 0; y < image.height(); ++y) std::fill_n(image.row(y), image.width(), gray);
  return image;
}

/// Mean of `length` pixels along x: the motion blur of a rotating camera.
GrayImage smeared(const GrayImage& image, int length) {
  GrayImage result(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      int sum = 0;
      for (int i = 0; i < length; ++i) sum += image.at(std::min(x + i, image.width() - 1), y);
      result.at(x, y) = static_cast<std::uint8_t>(sum / length);
    }
  }
  return result;
}

/// A check after ten good frames, 0.1 s apart, the last at 0.9 s.
FrameCheck after_good_frames() {
  FrameCheck check;
  for (int i = 0; i < 10; ++i) {
    const auto result = check.check(wave_image(160, 120, 2.0 * i, 0.0), i * step);
    EXPECT_EQ(result.reason, OdometryReason::none) << i << ' ' << result.detail;
    EXPECT_TRUE(result.useful());
  }
  return check;
}

TEST(FrameCheck, DetectsDarkBlankAndEmptyImages) {
  auto check = after_good_frames();
  for (const auto& image : {flat_image(0), flat_image(255), GrayImage()}) {
    const auto result = FrameCheck(check).check(image, 10 * step);
    EXPECT_EQ(result.reason, OdometryReason::dark_or_blank);
    EXPECT_FALSE(result.useful());
    EXPECT_FALSE(result.detail.empty());
  }
  check.check(flat_image(0), 10 * step);
  EXPECT_TRUE(check.check(wave_image(160, 120, 22.0, 0.0), 11 * step).useful());
}

TEST(FrameCheck, DetectsARepeatedImageButNotASmallMotion) {
  auto check = after_good_frames();
  EXPECT_EQ(check.check(wave_image(160, 120, 18.0, 0.0), 10 * step).reason, OdometryReason::repeated_frame);
  EXPECT_EQ(check.check(wave_image(160, 120, 18.2, 0.0), 11 * step).reason, OdometryReason::none);
}

TEST(FrameCheck, DetectsAStampThatDoesNotIncreaseAndAcceptsTheNextOne) {
  auto check = after_good_frames();
  EXPECT_EQ(check.check(wave_image(160, 120, 20.0, 0.0), 9 * step).reason, OdometryReason::repeated_frame);
  EXPECT_EQ(check.check(wave_image(160, 120, 22.0, 0.0), 3 * step).reason, OdometryReason::repeated_frame);
  EXPECT_EQ(check.check(wave_image(160, 120, 24.0, 0.0), 4 * step).reason, OdometryReason::none);
}

TEST(FrameCheck, DetectsBlurInOneDirectionAlone) {
  auto check = after_good_frames();
  const auto result = check.check(smeared(wave_image(160, 120, 20.0, 0.0), 14), 10 * step);
  EXPECT_EQ(result.reason, OdometryReason::blurred);
  EXPECT_LT(result.sharpness, 0.5);
  EXPECT_EQ(check.check(wave_image(160, 120, 22.0, 0.0), 11 * step).reason, OdometryReason::none);
}

TEST(FrameCheck, DetectsAGapAndKeepsItsFrame) {
  auto check = after_good_frames();
  EXPECT_EQ(check.check(wave_image(160, 120, 20.0, 0.0), 11 * step).reason, OdometryReason::none);
  const auto result = check.check(wave_image(160, 120, 40.0, 0.0), 14 * step);
  EXPECT_EQ(result.reason, OdometryReason::gap);
  EXPECT_TRUE(result.useful());
  EXPECT_NEAR(result.step_ratio, 3.0, 1e-9);
}

TEST(FrameCheck, RefusesAnotherSize) {
  auto check = after_good_frames();
  EXPECT_THROW(check.check(wave_image(161, 120, 0.0, 0.0), 10 * step), Error);
}

TEST(FrameCheck, AfterForgettingTheLastFrameMayComeAgain) {
  FrameCheck check;
  GrayImage image(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) image.at(x, y) = static_cast<std::uint8_t>(37 * x + 91 * y);
  EXPECT_TRUE(check.check(image.view(), 5).useful());
  EXPECT_EQ(check.check(image.view(), 6).reason, OdometryReason::repeated_frame);
  check.forget_last();
  EXPECT_TRUE(check.check(image.view(), 6).useful());
  EXPECT_EQ(check.check(image.view(), 7).reason, OdometryReason::repeated_frame);
}

}  // namespace
}  // namespace rastro
