// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/tum_rgbd/tum_rgbd.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

OpenOptions with_depth() {
  OpenOptions options;
  options.want_depth = true;
  return options;
}

TEST(TumRgbd, AssociationsMayWriteTheSameFileInAnotherWay) {
  const ScratchFolder folder;
  write_tum(folder, 2);
  folder.write("associations.txt",
               "1000.0 ./rgb/0.png 1000.004 ./depth/0.png\n1000.05 ./rgb/1.png 1000.054 ./depth/1.png\n");
  const auto source = open(folder.path(), with_depth());
  EXPECT_TRUE(source->info().has_depth);
  EXPECT_THAT(source->info().warnings, Not(Contains(HasSubstr("have a depth image"))));
  EXPECT_FLOAT_EQ(source->next()->depth.at(0, 0), 1.0F);
  EXPECT_FLOAT_EQ(source->next()->depth.at(0, 0), 1.001F);
}

TEST(TumRgbd, AssociationsOfOtherFilesGiveWayToTheDepthList) {
  const ScratchFolder folder;
  write_tum(folder, 2);
  folder.write("associations.txt", "1000.0 color/0.png 1000.004 depth/1.png\n");
  const auto source = open(folder.path(), with_depth());
  EXPECT_THAT(source->info().warnings,
              Contains(HasSubstr("associations.txt: names none of the images of rgb.txt; depth.txt is used")));
  EXPECT_FLOAT_EQ(source->next()->depth.at(0, 0), 1.0F);
  std::filesystem::remove(folder.path("depth.txt"));
  const auto none = open(folder.path(), with_depth());
  EXPECT_FALSE(none->info().has_depth);
  EXPECT_THAT(none->info().warnings, Contains("0 of 2 color images have a depth image in associations.txt"));
}

TEST(TumRgbd, DepthThatNeverFitsIsWarnedAbout) {
  const ScratchFolder folder;
  write_tum(folder, 2);
  folder.write("depth.txt", "2000.0 depth/0.png\n2000.05 depth/1.png\n");
  const auto source = open(folder.path(), with_depth());
  EXPECT_FALSE(source->info().has_depth);
  EXPECT_THAT(source->info().warnings, Contains("0 of 2 color images have a depth image within 0.02 s"));
}

TEST(TumRgbd, TheDepthFactorOfTheFolderComesBeforeThePublishedOne) {
  const ScratchFolder folder;
  const ScratchFolder all;
  write_tum(folder, 1);
  const std::string published = all.path("rgbd_dataset_freiburg1_xyz");
  std::filesystem::copy(folder.path(), published, std::filesystem::copy_options::recursive);
  EXPECT_EQ(open(published, with_depth())->info().depth_factor, 5000.0);
  all.write("rgbd_dataset_freiburg1_xyz/camera.yaml",
            "image_width: 8\nimage_height: 6\ncamera_matrix: [6, 0, 3.5, 0, 6, 2.5, 0, 0, 1]\n"
            "depth_factor: 4900\ndepth_offset_m: 0.01\n");
  const auto source = open(published, with_depth());
  EXPECT_EQ(source->info().depth_factor, 4900.0);
  EXPECT_EQ(source->info().depth_offset_m, 0.01);
  EXPECT_EQ(source->info().cameras.front().camera->fx, 6.0);
}

TEST(TumRgbd, AFileForTheDepthAloneIsNoCalibrationOfTheCamera) {
  const ScratchFolder folder;
  write_tum(folder, 1);
  folder.write("camera.yaml", "depth_factor: 2000\n");
  const auto bare = open(folder.path(), with_depth());
  EXPECT_EQ(bare->info().depth_factor, 2000.0);
  EXPECT_FALSE(bare->info().cameras.front().camera);
  folder.write("calibration.yaml", "camera_matrix: [6, 0, 3.5, 0, 6, 2.5, 0, 0, 1]\n");
  const auto both = open(folder.path(), with_depth());
  EXPECT_EQ(both->info().depth_factor, 2000.0);
  EXPECT_EQ(both->info().cameras.front().camera->fx, 6.0);
  folder.write("camera.yaml", "depth_factor: 2000\ncamera_matrix: [6, 0]\n");
  EXPECT_THAT(error_of([&] { open(folder.path(), with_depth()); }), HasSubstr("camera.yaml"));
}

}  // namespace
}  // namespace rastro
