// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/depth_image.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr int image_width = 320, image_height = 96;

/// A keyframe with a near square on the left, a far one on the right, and pixels enough for the scale.
std::shared_ptr<const SemiDenseDepth> two_squares() {
  SemiDenseDepth depth;
  for (std::uint16_t y = 20; y < 60; ++y)
    for (std::uint16_t x = 0; x < 40; ++x) {
      depth.pixels.push_back({static_cast<std::uint16_t>(30 + x), y, 2.0F, 0.0004F, 200});
      depth.pixels.push_back({static_cast<std::uint16_t>(200 + x), y, 0.2F, 0.0004F, 90});
    }
  return std::make_shared<const SemiDenseDepth>(std::move(depth));
}

Map map_of(int keyframes) {
  Map map;
  MapCamera camera;
  camera.intrinsics.width = image_width;
  camera.intrinsics.height = image_height;
  map.cameras.push_back(camera);
  auto layer = std::make_shared<SemiDenseLayer>();
  for (int id = 0; id < keyframes; ++id) {
    Keyframe keyframe;
    keyframe.id = id, keyframe.frame = 3 * id;
    map.keyframes.push_back(keyframe);
    if (id != 1) layer->of[id] = two_squares();
  }
  map.layers.put<SemiDenseLayer>(std::move(layer));
  return map;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(DepthImages, NearIsRedAndFarIsBlueBesideThePixelsThemselves) {
  const fs::path folder = scratch_folder("depth_images") / "depth";
  TaskPool pool(2);
  EXPECT_EQ(write_depth_images(map_of(4), folder, pool), 3U) << "one has none";
  EXPECT_FALSE(fs::exists(folder / "000001.jpg"));
  const cv::Mat drawn = cv::imread((folder / "000002.jpg").string());
  ASSERT_EQ(drawn.cols, 2 * image_width);
  ASSERT_GT(drawn.rows, image_height) << "with a caption";
  EXPECT_NEAR(drawn.at<cv::Vec3b>(40, 50)[1], 200, 8) << "the intensity";
  EXPECT_NEAR(drawn.at<cv::Vec3b>(40, 220)[1], 90, 8);
  const auto near = drawn.at<cv::Vec3b>(40, image_width + 50), far = drawn.at<cv::Vec3b>(40, image_width + 220);
  EXPECT_GT(near[2], near[0] + 80);
  EXPECT_GT(far[0], far[2] + 80);
  EXPECT_NEAR(drawn.at<cv::Vec3b>(80, image_width + 150)[1], 32, 8) << "not known";
}

TEST(DepthImages, TheStripShowsTwelveAtMostAndThreadsDoNotMatter) {
  const fs::path folder = scratch_folder("depth_strip");
  const Map map = map_of(30);
  TaskPool one(1), two(2);
  write_depth_images(map, folder / "one", one);
  write_depth_images(map, folder / "two", two);
  const cv::Mat strip = cv::imread((folder / "one" / "strip.png").string());
  EXPECT_EQ(strip.cols, 4 * 320);
  EXPECT_EQ(strip.rows, 3 * 96);
  for (const char* name : {"000000.jpg", "000029.jpg", "strip.png"})
    EXPECT_EQ(bytes_of(folder / "one" / name), bytes_of(folder / "two" / name)) << name;
}

/// Motion JPEG: the size is that of the images, ten for each second.
TEST(DepthVideo, ShowsEachKeyframeUntilTheNext) {
  const fs::path folder = scratch_folder("depth_video");
  const auto size_with_steps_of = [&](TimeNs step) -> std::uintmax_t {
    Map map = map_of(5);
    for (Keyframe& keyframe : map.keyframes) keyframe.stamp = keyframe.id * step;
    const fs::path file = folder / fmt::format("{}.avi", step);
    EXPECT_EQ(write_depth_video(map, file), 4U);
    return fs::file_size(file);
  };
  try {
    const auto usual = size_with_steps_of(ns_per_second / 10);
    const auto slow = size_with_steps_of(ns_per_second);
    // Steps of the four with depth: 2, 1 and 1, and the last is shown once.
    EXPECT_NEAR(static_cast<double>(slow) / static_cast<double>(usual), 41.0 / 5.0, 1.0);
  } catch (const Error& error) {
    ASSERT_NE(std::string(error.what()).find("built without video"), std::string::npos) << error.what();
    GTEST_SKIP() << "built without video files";
  }
  EXPECT_THROW(write_depth_video(map_of(3), folder / "depth.jpg"), Error);
}

TEST(DepthImages, AMapWithoutSemiDenseDepthIsAnError) {
  EXPECT_THROW(write_depth_video(Map(), "depth.avi"), Error);
  TaskPool pool(1);
  EXPECT_THROW(write_depth_images(Map(), scratch_folder("depth_none"), pool), Error);
}

}  // namespace
}  // namespace rastro
