// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/rosbag/rosbag.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/dataset/check.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

#if RASTRO_WITH_ROSBAG

#include <opencv2/imgcodecs.hpp>

#include "rastro/base/random.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/rosbag/bag_messages.h"
#include "rastro/dataset/rosbag/bag_writer_testing.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

TEST(RosBag, ScansComeWithOdometryAndInertialReadings) {
  const ScratchFolder folder;
  {
    BagWriter bag(folder.path("a.bag"), rosbag::compression::LZ4);
    for (int k = 0; k < 10; ++k) {
      bag.imu(k - 0.2, k);
      bag.imu(k - 0.1, k);
      bag.odometry(k - 0.05, 0.5 * k, 0.1 * k);
      bag.scan("/scan", k);
      bag.scan("/rear/scan_unused", k + 0.01);
    }
  }
  OpenOptions options;
  options.first_frame = 2;
  options.every = 3;
  const auto source = open(folder.path("a.bag"), options);
  const auto& info = source->info();
  EXPECT_EQ(info.format, "rosbag");
  EXPECT_EQ(info.frame_count, 10);
  EXPECT_TRUE(info.has_scan && info.has_odometry && info.has_imu && !info.has_image && !info.has_depth);
  EXPECT_THAT(info.warnings, Contains(HasSubstr("topic /rear/scan_unused is read, not /scan")));
  for (const int k : {2, 5, 8}) {
    const auto frame = source->next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, k);
    EXPECT_EQ(frame->stamp, (1000 + k) * ns_per_second + 10'000'000);
    EXPECT_NEAR(frame->odometry_from_body->translation().x(), 0.5 * k, 1e-12);
    EXPECT_NEAR(frame->odometry_from_body->rotation().angle(), 0.1 * k, 1e-12);
    EXPECT_EQ(frame->imu.size(), 6u);  // Of this frame and of the two omitted before it.
    EXPECT_EQ(frame->imu.back().angular_velocity.z(), k);
    EXPECT_EQ(frame->imu.back().acceleration.z(), 9.81);
    const LaserScan& scan = *frame->scan;
    EXPECT_TRUE(scan.is_return(0) && scan.is_free(1) && !scan.is_free(2) && !scan.is_return(2));
    EXPECT_EQ(scan.ranges[3], static_cast<float>(k) + 0.01F + 2.0F);
    EXPECT_EQ(scan.angle_step, 0.5);
  }
  EXPECT_FALSE(source->next());
}

TEST(RosBag, ImagesComeWithTheNearestDepthAndTheirCalibration) {
  const ScratchFolder folder;
  {
    BagWriter bag(folder.path("a.bag"));
    bag.camera_info("/camera/rgb/camera_info", 0.0);
    bag.camera_info("/another/camera_info", 0.0);
    for (int k = 0; k < 5; ++k) {
      const auto value = static_cast<std::uint8_t>(10 * k + 10);
      bag.image("/camera/depth/image", k - 0.015, "16UC1", {0xB8, 0x0B});  // 3000 mm, 15 ms before.
      bag.image("/camera/rgb/image_color", k, "rgb8", {value, 0, 0});
      // 2.5 m, 4 ms behind; the third one is missing.
      if (k != 2) bag.image("/camera/depth/image", k + 0.004, "16UC1", {0xC4, 0x09});
    }
  }
  OpenOptions options;
  options.want_depth = options.want_color = true;
  const auto source = open(folder.path("a.bag"), options);
  const auto& info = source->info();
  EXPECT_EQ(info.frame_count, 5);
  EXPECT_TRUE(info.has_image && info.has_depth && !info.has_scan);
  ASSERT_TRUE(info.cameras.front().camera.has_value());
  EXPECT_EQ(info.cameras.front().calibration_file, "/camera/rgb/camera_info");
  EXPECT_EQ(info.cameras.front().camera->fy, 9.5);
  EXPECT_EQ(info.cameras.front().camera->coefficients[4], 0.003);
  for (int k = 0; k < 5; ++k) {
    const auto frame = source->next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->color.rgb.at(3 * 3, 2), 10 * k + 10);
    EXPECT_EQ(frame->image.width(), 8);
    EXPECT_NEAR(frame->depth.at(7, 5), k == 2 ? 3.0F : 2.5F, 1e-6F);
    EXPECT_EQ(frame->depth_stamp - frame->stamp, k == 2 ? -15'000'000 : 4'000'000);
  }
  EXPECT_FALSE(source->next());
  const auto report = check(folder.path("a.bag"), {});
  EXPECT_EQ(report.depth.frames_with_depth, 5);
  EXPECT_EQ(report.depth.depth_measured_percent, 100.0);
}

TEST(RosBag, DepthIsCorrectedAndPutIntoColorAsItWasCalibrated) {
  const ScratchFolder folder;
  {
    BagWriter bag(folder.path("a.bag"));
    for (int k = 0; k < 2; ++k) {
      bag.image("/camera/depth/image", k, "16UC1", {0xD0, 0x07}, 16, 12);  // 2000 mm
      bag.image("/camera/rgb/image_color", k, "rgb8", {50, 0, 0});
    }
  }
  const std::string color = "image_width: 8\nimage_height: 6\ncamera_matrix: [8, 0, 3.5, 0, 8, 2.5, 0, 0, 1]\n";
  const std::string beside =
      "depth_camera:\n  image_width: 16\n  image_height: 12\n"
      "  camera_matrix: [12, 0, 7.5, 0, 12, 5.5, 0, 0, 1]\n"
      "color_from_depth: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -0.5, 0, 0, 0, 1]\n";
  folder.write("corrected.yaml", color + "depth_factor: 800\ndepth_offset_m: 0.01\n" + beside);
  folder.write("tum.yaml", color + "depth_factor: 5000\n" + beside);
  OpenOptions options;
  options.want_depth = true;
  options.calibration_file = folder.path("corrected.yaml");
  const auto corrected = open(folder.path("a.bag"), options);
  EXPECT_EQ(corrected->info().depth_factor, 800.0);
  EXPECT_EQ(corrected->info().depth_offset_m, 0.01);
  const DepthImage depth = corrected->next()->depth;
  ASSERT_EQ(depth.width(), 8);
  EXPECT_NEAR(depth.at(4, 3), 2.0F * 1.25F + 0.01F - 0.5F, 1e-5F);
  options.calibration_file = folder.path("tum.yaml");
  const auto foreign = open(folder.path("a.bag"), options);
  EXPECT_THAT(foreign->info().warnings, Contains(HasSubstr("depth_factor 5000 is not used")));
  EXPECT_NEAR(foreign->next()->depth.at(4, 3), 1.5F, 1e-5F);
  options.calibration_file.clear();
  EXPECT_THAT(error_of([&] { open(folder.path("a.bag"), options)->next(); }), HasSubstr("another size"));
}

TEST(RosBag, AnImageTopicCanBeNamedAndABrokenImageCostsOnlyItself) {
  const ScratchFolder folder;
  {
    BagWriter bag(folder.path("a.bag"));
    for (int k = 0; k < 4; ++k) {
      bag.scan("/scan", k);
      bag.image("/right", k, k == 1 ? "what" : "mono8", {static_cast<std::uint8_t>(k + 1)});
      std::vector<std::uint8_t> bytes;
      cv::imencode(".png", cv::Mat(6, 8, CV_8UC1, cv::Scalar(40 + k)), bytes);
      CompressedMessage packed;
      packed.format = "png";
      packed.data.assign(bytes.begin(), k == 2 ? bytes.begin() + 30 : bytes.end());
      bag.write("/packed", k, packed);
    }
  }
  EXPECT_THAT(open(folder.path("a.bag"))->info().warnings, Contains(HasSubstr("--camera TOPIC gives the images")));
  for (const std::string topic : {"/right", "/packed"}) {
    OpenOptions options;
    options.camera = topic;
    const auto source = open(folder.path("a.bag"), options);
    int read = 0;
    std::string problem;
    for (int k = 0; k < 4; ++k) {
      try {
        const auto frame = source->next();
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->index, k);
        EXPECT_EQ(frame->image.at(4, 4), topic == "/right" ? k + 1 : 40 + k);
        ++read;
      } catch (const Error& error) {
        problem = error.what();
      }
    }
    EXPECT_EQ(read, 3);
    EXPECT_THAT(problem, HasSubstr("topic " + topic));
    EXPECT_FALSE(source->next());
  }
  OpenOptions options;
  options.camera = "/nothing";
  EXPECT_THAT(error_of([&] { open(folder.path("a.bag"), options); }), HasSubstr("there is no image topic '/nothing'"));
}

void write_scans(const std::string& path, rosbag::compression::CompressionType packed) {
  BagWriter bag(path, packed);
  for (int k = 0; k < 200; ++k) {
    bag.odometry(k - 0.05, k, 0.0);
    bag.scan("/scan", k);
  }
}

TEST(RosBag, ABagThatWasCutShortIsReadAsFarAsItIsWhole) {
  const ScratchFolder folder;
  for (const auto packed : {rosbag::compression::Uncompressed, rosbag::compression::LZ4, rosbag::compression::BZ2}) {
    for (const double share : {0.9, 0.4}) {
      write_scans(folder.path("cut.bag"), packed);
      folder.truncate("cut.bag", share);
      const auto source = open(folder.path("cut.bag"));
      EXPECT_THAT(source->info().warnings, Contains(HasSubstr("complete messages are read")));
      std::int64_t count = 0;
      while (const auto frame = source->next()) {
        EXPECT_EQ(frame->index, count);
        EXPECT_EQ(frame->stamp, nanoseconds(at(static_cast<double>(count))));
        EXPECT_EQ(frame->odometry_from_body->translation().x(), count);
        EXPECT_TRUE(frame->scan->is_return(0));
        ++count;
      }
      EXPECT_EQ(count, source->info().frame_count);
      // A chunk holds some ten scans, and the index behind them takes its share of the bytes.
      EXPECT_GT(static_cast<double>(count), 200 * share - 40);
      if (share < 0.5) {
        EXPECT_LT(count, 200);
      }
    }
  }
}

/// What is left of a damaged bag of write_scans().
struct Salvage {
  bool opened = false;
  int frames = 0, wrong = 0, errors = 0;
  bool ended = false, in_order = true;
  std::vector<std::string> messages;
};

Salvage salvaged(const std::string& path) {
  Salvage salvage;
  std::unique_ptr<Source> source;
  salvage.messages.push_back(error_of([&] { source = open(path); }));
  salvage.opened = source != nullptr;
  std::int64_t last = -1;
  for (int call = 0; source && !salvage.ended && call < 450; ++call) {
    std::optional<Frame> frame;
    salvage.messages.push_back(error_of([&] { frame = source->next(); }));
    if (!salvage.messages.back().empty()) {
      ++salvage.errors;
      continue;
    }
    salvage.ended = !frame;
    if (!frame) break;
    ++salvage.frames;
    salvage.in_order = salvage.in_order && frame->index > last;
    last = frame->index;
    // The stamp says which scan it should be; where that itself is damaged, no scan is right.
    const TimeNs since = frame->stamp - nanoseconds(at(0.0)), k = since / ns_per_second;
    const bool right = since == k * ns_per_second && frame->scan && frame->scan->ranges.size() == 4 &&
                       frame->scan->ranges[0] == 1.0F && frame->scan->ranges[3] == static_cast<float>(k) + 2.0F;
    salvage.wrong += right ? 0 : 1;
  }
  return salvage;
}

TEST(RosBag, DamagedBytesEndTheBagAndNothingWrongIsReadBeforeThem) {
  const ScratchFolder folder;
  write_scans(folder.path("whole.bag"), rosbag::compression::LZ4);
  const std::string whole = read_text_file(folder.path("whole.bag"));
  const Salvage all = salvaged(folder.path("whole.bag"));
  ASSERT_TRUE(all.ended);
  ASSERT_EQ(std::pair(all.frames, all.wrong), std::pair(200, 0));
  Random random(7);
  int opened = 0, frames = 0, wrong = 0;
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(trial);
    std::string damaged = whole;
    for (int k = 0; k < 3; ++k)
      damaged[random.below(static_cast<std::uint32_t>(whole.size()))] = static_cast<char>(random.below(256));
    folder.write("damaged.bag", damaged);
    const Salvage salvage = salvaged(folder.path("damaged.bag"));
    EXPECT_TRUE(!salvage.opened || salvage.ended) << "it never comes to an end";
    EXPECT_TRUE(salvage.in_order);
    EXPECT_LE(salvage.frames + salvage.errors, 200);
    for (const std::string& message : salvage.messages) {
      if (message.empty()) continue;
      EXPECT_THAT(message, HasSubstr("damaged.bag"));
      EXPECT_THAT(message, Not(HasSubstr("\n")));
    }
    opened += salvage.opened ? 1 : 0;
    frames += salvage.frames;
    wrong += salvage.wrong;
  }
  EXPECT_EQ(wrong, 0) << "chunks hold checksums";
  // Measured: 59 open, and 5239 of their scans come before the first byte that is damaged.
  EXPECT_GE(opened, 57);
  EXPECT_GE(frames, 4700);
}

TEST(RosBag, WhatHoldsNothingToReadIsAnErrorOfOneLine) {
  const ScratchFolder folder;
  {
    BagWriter bag(folder.path("a.bag"));
    for (int k = 0; k < 200; ++k) bag.odometry(k, k, 0.0);
  }
  const auto nothing = error_of([&] { open(folder.path("a.bag")); });
  EXPECT_THAT(nothing, HasSubstr("has neither laser scans nor images"));
  EXPECT_THAT(nothing, HasSubstr("/odom (nav_msgs/Odometry)"));
  folder.write("text.bag", "no bag at all\n");
  EXPECT_THAT(error_of([&] { open(folder.path("text.bag")); }), HasSubstr("text.bag"));
}

}  // namespace
}  // namespace rastro

#else

namespace rastro {
namespace {

TEST(RosBag, IsRefusedInABuildWithout) {
  const ScratchFolder folder;
  folder.write("a.bag", "#ROSBAG V2.0\n");
  EXPECT_THAT(error_of([&] { open(folder.path("a.bag")); }), testing::HasSubstr("this build reads no ROS bags"));
}

}  // namespace
}  // namespace rastro

#endif
