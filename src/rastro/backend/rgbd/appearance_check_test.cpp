// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/appearance_check.h"

#include <gtest/gtest.h>

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
UnpackedImages wall(std::uint64_t seed, float light = 1.0F) {
  UnpackedImages images{{Image<std::uint8_t>(3 * width, height)}, DepthImage(width, height)};
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

AppearanceAgreement compare(const UnpackedImages& a, const UnpackedImages& b, const SE3& a_from_b = SE3()) {
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

TEST(AppearanceCheck, WhatIsHiddenOrWithoutTextureSaysNothing) {
  UnpackedImages hidden = wall(2), plain = wall(2);
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
