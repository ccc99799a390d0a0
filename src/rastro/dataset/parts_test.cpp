// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/image_file.h"
#include "rastro/dataset/images/images.h"
#include "rastro/dataset/kitti/kitti_images.h"
#include "rastro/dataset/stamped_list.h"
#include "rastro/dataset/tum_rgbd/depth_factor.h"
#include "rastro/dataset/tum_rgbd/published_intrinsics.h"
#include "rastro/image/image.h"

namespace rastro {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Folder, SortsAsPeopleDo) {
  std::vector<std::string> names = {"b10.png", "b9.png", "a.png", "b009.png", "b1.png", "b"};
  std::sort(names.begin(), names.end(), natural_less);
  EXPECT_THAT(names, ElementsAre("a.png", "b", "b1.png", "b009.png", "b9.png", "b10.png"));
  for (const auto& a : names) EXPECT_FALSE(natural_less(a, a));
}

TEST(Associate, TakesNearestPairsFirstAndEachOnce) {
  const std::vector<ListedImage> color = {{0, ""}, {100, ""}, {200, ""}, {1000, ""}};
  const std::vector<ListedImage> depth = {{90, ""}, {196, ""}, {105, ""}};
  // 196 is 4 from 200; 105 is 5 from 100; 90 is left to nothing within 50 but 0 is 90 away.
  EXPECT_THAT(associate(color, depth, 50), ElementsAre(-1, 2, 1, -1));
  EXPECT_THAT(associate(color, depth, 90), ElementsAre(0, 2, 1, -1));
  EXPECT_THAT(associate(color, {}, 90), ElementsAre(-1, -1, -1, -1));
}

TEST(ImageFile, ColorBecomesGrayByTheWeightsOfGrayFromColor) {
  const ScratchFolder folder;
  cv::Mat mat(7, 9, CV_8UC3);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 9; ++x) mat.at<cv::Vec3b>(y, x) = cv::Vec3b(x * 28, y * 36, (x * y * 5) % 256);
  }
  cv::imwrite(folder.path("c.png"), mat);
  const auto image = read_image(folder.path("c.png"), true);
  const auto expected = gray_from_color(image.color);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 9; ++x) {
      EXPECT_EQ(image.gray.at(x, y), expected.at(x, y));
      EXPECT_EQ(image.color.rgb.at(3 * x, y), mat.at<cv::Vec3b>(y, x)[2]) << "red comes first";
    }
  }
}

TEST(ImageFile, SixteenBitIsScaledToEight) {
  const ScratchFolder folder;
  folder.write_depth("d.png", 65535);
  folder.write_depth("half.png", 32768);
  EXPECT_EQ(read_image(folder.path("d.png")).gray.at(0, 0), 255);
  EXPECT_EQ(read_image(folder.path("half.png")).gray.at(0, 0), 128);
}

TEST(ImageFile, NoTruncatedFilePassesForAWholeOne) {
  const ScratchFolder folder;
  cv::Mat noise(48, 64, CV_8UC1);
  cv::randu(noise, 0, 256);
  for (const char* ending : {".png", ".jpg"}) {
    const std::string name = std::string("n") + ending;
    for (const double share : {0.999, 0.9, 0.5, 0.1, 0.01}) {
      cv::imwrite(folder.path(name), noise);
      EXPECT_EQ(error_of([&] { read_image(folder.path(name)); }), "");
      folder.truncate(name, share);
      EXPECT_THAT(error_of([&] { read_image(folder.path(name)); }), HasSubstr(folder.path(name)))
          << name << " " << share;
    }
  }
  EXPECT_THAT(error_of([&] { read_image(folder.path("n.png")); }), HasSubstr(": "));
}

TEST(ImageFile, DamageInsideIsAnError) {
  const ScratchFolder folder;
  folder.write("text.png", "this is no image");
  EXPECT_THAT(error_of([&] { read_image(folder.path("text.png")); }), HasSubstr("cannot be decoded as an image"));
  folder.write_gray("gray.png", 7);
  EXPECT_THAT(error_of([&] { read_raw_depth(folder.path("gray.png")); }),
              HasSubstr("one channel of 16 bit, this has 1 of 8"));
  EXPECT_THAT(error_of([&] { read_image(folder.path("none.png")); }), HasSubstr("no such file"));
  folder.write("empty.png", "");
  EXPECT_THAT(error_of([&] { read_image(folder.path("empty.png")); }), HasSubstr("is empty"));
}

TEST(DepthFactor, IsReadOrGuessed) {
  EXPECT_EQ(parse_depth_factor("# c\nDepthMapFactor: 5000.0\n", "f"), 5000.0);
  EXPECT_EQ(parse_depth_factor("m_depthShift = 1000", "f"), 1000.0);
  EXPECT_EQ(parse_depth_factor("depth_scale: 0.001 # meters a unit", "f"), 1000.0);
  EXPECT_FALSE(parse_depth_factor("fx: 500", "f"));
  EXPECT_EQ(parse_depth_offset("depth_factor: 5000\ndepth_offset_m: -0.004\n", "f"), -0.004);
  EXPECT_EQ(parse_depth_offset("depth_factor: 5000\n", "f"), 0.0);
  EXPECT_THAT(error_of([] { parse_depth_offset("depth_offset_m: 4", "f.yaml"); }), HasSubstr("f.yaml:1"));
  EXPECT_THAT(error_of([] { parse_depth_factor("\ndepth_factor: -1", "f.yaml"); }),
              HasSubstr("f.yaml:2: the depth factor '-1'"));

  const auto image_of = [](int first, int step) {
    std::vector<Image<std::uint16_t>> images(1, Image<std::uint16_t>(40, 40));
    for (int k = 0; k < 1600; ++k) images[0].at(k % 40, k / 40) = static_cast<std::uint16_t>(first + step * k);
    return images;
  };
  EXPECT_EQ(guess_depth_factor(image_of(5000, 5)).units_per_meter, 5000.0) << "Kinect millimeters written times five";
  EXPECT_EQ(guess_depth_factor(image_of(900, 2)).units_per_meter, 1000.0) << "a room in millimeters";
  EXPECT_EQ(guess_depth_factor(image_of(6001, 9)).units_per_meter, 5000.0) << "a room of 4 m rendered at 5000";
  auto saturated = image_of(6001, 9);
  saturated[0].at(0, 0) = 65535;
  EXPECT_EQ(guess_depth_factor(saturated).units_per_meter, 1000.0);
  EXPECT_EQ(guess_depth_factor({}).units_per_meter, 5000.0);
}

TEST(DepthInMeters, ZeroAndSaturationAreNone) {
  Image<std::uint16_t> raw(3, 1);
  raw.at(1, 0) = 65535;
  raw.at(2, 0) = 2500;
  const auto depth = depth_in_meters(raw, 5000.0);
  EXPECT_EQ(depth.at(0, 0), 0.0f);
  EXPECT_EQ(depth.at(1, 0), 0.0f);
  EXPECT_EQ(depth.at(2, 0), 0.5f);
  const auto moved = depth_in_meters(raw, 5000.0, 0.25);
  EXPECT_EQ(moved.at(0, 0), 0.0f);
  EXPECT_EQ(moved.at(2, 0), 0.75f);
}

TEST(PublishedTum, GoesByTheFolderName) {
  EXPECT_NEAR(tum_camera_of_folder("/data/rgbd_dataset_freiburg1_xyz/")->camera->fx, 517.3, 1e-9);
  EXPECT_NEAR(tum_camera_of_folder("/data/tum_fr2_desk")->camera->fx, 520.9, 1e-9);
  EXPECT_EQ(tum_camera_of_folder("/data/fr3/clip")->camera->distortion, Distortion::none);
  EXPECT_FALSE(tum_camera_of_folder("/data/afr1b"));
  EXPECT_FALSE(tum_camera_of_folder("/data/kitchen"));
}

TEST(KittiImages, RowsGoByNumberWhereTheyCan) {
  EXPECT_THAT(rows_of_images({"000003.png", "000004.png"}, 10), ElementsAre(3, 4));
  EXPECT_THAT(rows_of_images({"000003.png", "000004.png"}, 2), ElementsAre(0, 1));
  EXPECT_THAT(rows_of_images({"a.png", "b.png"}, 1), ElementsAre(0, -1));
}

TEST(Images, StampsFromNamesNeedSixteenRisingDigits) {
  EXPECT_THAT(*stamps_from_names({"1403715285262142976.png", "1403715285312143104.png"}),
              ElementsAre(1403715285262142976, 1403715285312143104));
  EXPECT_FALSE(stamps_from_names({"000001.png", "000002.png"}));
  EXPECT_FALSE(stamps_from_names({"1403715285312143104.png", "1403715285262142976.png"}));
  EXPECT_FALSE(stamps_from_names({"99999999999999999999.png"}));
}

TEST(Images, TheUnitOfWholeNumbersIsGuessed) {
  EXPECT_THAT(*stamps_from_names({"1418381798086398.png", "1418381798136382.png"}),
              ElementsAre(1418381798086398000, 1418381798136382000));
  EXPECT_THAT(*stamps_from_names({"1418381798086.jpg", "1418381798136.jpg"}),
              ElementsAre(1418381798086000000, 1418381798136000000));
  EXPECT_THAT(*stamps_from_names({"0000001234567890123.png", "0000001234600890123.png"}),
              ElementsAre(1234567890123, 1234600890123));
  EXPECT_FALSE(stamps_from_names({"0000000000000001.png", "0000000000000002.png"})) << "numbers of images";
  EXPECT_FALSE(stamps_from_names({"20230101120000.jpg", "20230101120005.jpg"})) << "a date in digits";
  EXPECT_FALSE(stamps_from_names({}));
}

TEST(Images, StampsFromNamesMayBeSecondsWithAFraction) {
  EXPECT_THAT(*stamps_from_names({"1305031102.175304.png", "1305031102.211214.png"}),
              ElementsAre(1305031102175304000, 1305031102211214000));
  EXPECT_FALSE(stamps_from_names({"1.5.png", "2.5.png"})) << "a version, not a time";
  EXPECT_FALSE(stamps_from_names({"1305031102.1.2.png", "1305031102.1.3.png"}));
  EXPECT_FALSE(stamps_from_names({"1305031102.175304.png", "1403715285262142976.png"})) << "of two kinds";
}

}  // namespace
}  // namespace rastro
