// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/kitti/kitti_images.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

using testing::Contains;

OpenOptions with_right() {
  OpenOptions options;
  options.want_right = true;
  return options;
}

TEST(KittiImages, RightImagesMayBePackedDifferently) {
  const ScratchFolder folder;
  write_kitti(folder, 3, 0);
  for (int k = 0; k < 3; ++k) folder.write_gray(fmt::format("image_1/{:06}.jpg", k), 110 + k);
  const auto source = open(folder.path(), with_right());
  EXPECT_TRUE(source->info().has_right);
  EXPECT_EQ(source->next()->right.at(0, 0), 110);
}

TEST(KittiImages, RightImagesOfOtherNamesAreWarnedAbout) {
  const ScratchFolder folder;
  write_kitti(folder, 3, 0);
  for (int k = 0; k < 3; ++k) folder.write_gray(fmt::format("image_1/right_{:06}.png", k), 110 + k);
  const auto source = open(folder.path(), with_right());
  EXPECT_FALSE(source->info().has_right);
  EXPECT_THAT(source->info().warnings, Contains("0 of 3 frames have an image in image_1"));
}

}  // namespace
}  // namespace rastro
