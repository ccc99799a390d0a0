// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/appearance_check.h"

#include <gtest/gtest.h>

#include <vector>

#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr int width = 160, height = 120;

Camera small_camera() {
  Camera camera;
  camera.width = width, camera.height = height;
  camera.fx = camera.fy = 130.0, camera.cx = 79.5, camera.cy = 59.5;
  return camera;
}

/// A wall at 2 m, facing the camera; `seed` paints its right half, 1 its left one.
Frame wall(std::uint64_t seed, float light = 1.0F) {
  Frame images;
  images.color.rgb = Image<std::uint8_t>(3 * width, height);
  images.depth = DepthImage(width, height);
  Random left(1), right(seed);
  for (int y = 0; y < height; y += 4)
    for (int x = 0; x < width; x += 4) {
      const double value = (x < width / 2 ? left : right).uniform(40.0, 160.0);
      for (int v = y; v < y + 4; ++v)
        for (int u = x; u < x + 4; ++u) {
          images.depth.at(u, v) = 2.0F;
          for (int c = 0; c < 3; ++c)
            images.color.rgb.at(3 * u + c, v) = static_cast<std::uint8_t>(light * static_cast<float>(value));
        }
    }
  return images;
}

AppearanceAgreement compare(const Frame& a, const Frame& b, const SE3& a_from_b = SE3()) {
  const AppearanceCheck check(small_camera());
  return check.compare(check.appearance_of(a), check.appearance_of(b), a_from_b);
}

TEST(AppearanceCheck, TheSameWallLooksAlikeInAnyLight) {
  for (const float light : {1.0F, 0.6F, 1.5F}) {
    const AppearanceAgreement agreement = compare(wall(2), wall(2, light));
    EXPECT_GT(agreement.agree, 200) << light;
    EXPECT_EQ(agreement.contradict, 0) << light;
    EXPECT_GT(agreement.cells, 40) << light;
    EXPECT_NEAR(agreement.center.z(), 2.0, 1e-6);
    EXPECT_NEAR(agreement.center.x(), 0.0, 0.05);
  }
}

TEST(AppearanceCheck, WhatIsPaintedOtherwiseContradicts) {
  const AppearanceAgreement agreement = compare(wall(2), wall(3));
  EXPECT_NEAR(agreement.agree, agreement.contradict, 30) << "one half is the same";
  EXPECT_LT(agreement.center.x(), -0.4) << "the left one";
  EXPECT_LT(agreement.cells, 30);
}

TEST(AppearanceCheck, AnotherPoseOfTheSameWallContradicts) {
  const AppearanceAgreement moved = compare(wall(2), wall(2), SE3(SO3(), {0.3, 0.0, 0.0}));
  EXPECT_GT(moved.contradict, 10 * moved.agree);
}

/// Columns and rows of blocks, each brighter or darker by a random part of its amplitude.
Frame plaid(double of_columns, double of_rows) {
  Frame images = wall(2);
  Random random(4);
  std::vector<double> columns(width / 4), rows(height / 4);
  for (double& value : columns) value = random.uniform(-of_columns, of_columns);
  for (double& value : rows) value = random.uniform(-of_rows, of_rows);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < 3 * width; ++x)
      images.color.rgb.at(x, y) = static_cast<std::uint8_t>(120.0 + columns[static_cast<std::size_t>(x / 12)] +
                                                            rows[static_cast<std::size_t>(y / 4)]);
  return images;
}

/// Along stripes, a patch may be anywhere.
TEST(AppearanceCheck, TextureIsWhatVariesInBothDirections) {
  const AppearanceAgreement stripes = compare(plaid(80.0, 0.0), plaid(80.0, 0.0)),
                            both = compare(plaid(80.0, 20.0), plaid(80.0, 20.0));
  EXPECT_EQ(stripes.agree, 0);
  EXPECT_GT(both.agree, 200);
}

/// Patches of 8 with a margin of 1 begin at 0 and end at 146 of 147 columns, 122 of 123 rows, and the next ones 8
/// before: those at the right and the lower end leave the other view as soon as anything moves.
TEST(AppearanceCheck, APatchCountsWhereAllOfItIsInTheOtherView) {
  Camera camera = small_camera();
  camera.width = 146, camera.height = 114;
  const AppearanceCheck check(camera);
  const KeyframeAppearance seen = check.appearance_of(wall(2));
  const auto compared = [&](double right_px, double down_px) {
    const SE3 moved(SO3(), {right_px * 2.0 / camera.fx, down_px * 2.0 / camera.fx, 0.0});
    const AppearanceAgreement agreement = check.compare(seen, seen, moved);
    return agreement.agree + agreement.contradict;
  };
  const int all = compared(-0.2, -0.2);
  EXPECT_EQ(all, compared(0.2, 0.2)) << "a row and a column each";
  EXPECT_LT(all, 18 * 14);
  EXPECT_GT(all, 16 * 12);
}

TEST(AppearanceCheck, DepthsThatDifferByTheirNoiseAreOneSurface) {
  Frame noisy = wall(2);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) noisy.depth.at(x, y) = 2.2F;
  const auto compared = [&](const DepthNoise& noise) {
    const AppearanceCheck check(small_camera(), noise);
    const AppearanceAgreement agreement =
        check.compare(check.appearance_of(noisy), check.appearance_of(wall(2)), SE3());
    return agreement.agree + agreement.contradict;
  };
  EXPECT_EQ(compared({}), 0) << "of a Kinect: the wall is hidden";
  EXPECT_GT(compared({0.0, 0.02}), 200) << "8 cm at 2 m";
  EXPECT_EQ(compared({0.0, 0.015}), 0) << "6 cm at 2 m";
}

TEST(AppearanceCheck, WhatIsHiddenOrWithoutTextureSaysNothing) {
  Frame hidden = wall(2), plain = wall(2);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      hidden.depth.at(x, y) = 1.0F;
      for (int c = 0; c < 3; ++c) plain.color.rgb.at(3 * x + c, y) = 90;
    }
  const AppearanceAgreement of_hidden = compare(hidden, wall(2)), of_plain = compare(plain, plain);
  EXPECT_EQ(of_hidden.agree + of_hidden.contradict, 0);
  EXPECT_EQ(of_plain.agree + of_plain.contradict, 0);
}

}  // namespace
}  // namespace rastro
