// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/rotation_search.h"

#include <gtest/gtest.h>

#include "rastro/slam/lsd/tracking/alignment_testing.h"

namespace rastro {
namespace {

TEST(RotationSearch, FindsRotationsFarBeyondWhatAnAlignmentConvergesFrom) {
  testing::AlignmentRoom room;
  constexpr int level = 3;
  constexpr double pixel_rad = 8.0 / 256.0;  // of the small image
  const Pyramid before = alignment_pyramid(room.render(SE3()).gray, level + 1);
  for (const Eigen::Vector3d& rotation :
       {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.0, 0.25, 0.0), Eigen::Vector3d(0.12, -0.2, 0.0)}) {
    const SE3 b_from_a(SO3::exp(rotation), {0.02, 0.0, 0.01});
    const Pyramid after = alignment_pyramid(room.render(b_from_a.inverse()).gray, level + 1);
    const RotationGuess found =
        find_rotation(before.level(level).view(), after.level(level).view(), LevelCamera(room.camera(), level));
    EXPECT_LT((found.b_from_a.inverse() * b_from_a.rotation()).log().norm(), 1.2 * pixel_rad) << rotation.transpose();
    EXPECT_GT(found.correlation, 0.7);
  }
}

TEST(RotationSearch, AFlatImageHasNoCorrelation) {
  const GrayImage flat(40, 30);
  EXPECT_EQ(find_rotation(flat.view(), flat.view(), LevelCamera()).correlation, -1.0);
}

}  // namespace
}  // namespace rastro
