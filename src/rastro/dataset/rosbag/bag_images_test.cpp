// SPDX-License-Identifier: Apache-2.0
#if RASTRO_WITH_ROSBAG

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/rosbag/bag_writer_testing.h"

namespace rastro {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* color_topic = "/camera/rgb/image_raw";
constexpr const char* depth_topic = "/camera/depth/image_raw";
constexpr int frame_count = 30;

OpenOptions with_depth() {
  OpenOptions options;
  options.want_depth = true;
  options.field_of_view_deg = 60.0;
  return options;
}

/// Color and depth of the same stamps 1/30 s apart, each recorded so much later; depth of frame k is 1000 + k mm. In
/// the order of recording, as rosbag record writes them.
void write_delayed(const std::string& path, double color_late_s, double depth_late_s, double depth_offset_s = 0.0) {
  struct Event {
    double recorded;
    int frame;
    bool is_depth;
  };
  std::vector<Event> events;
  for (int k = 0; k < frame_count; ++k) {
    events.push_back({k / 30.0 + color_late_s, k, false});
    events.push_back({k / 30.0 + depth_late_s, k, true});
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.recorded < b.recorded; });
  BagWriter bag(path);
  for (const auto& event : events) {
    bag.late_s = event.is_depth ? depth_late_s - depth_offset_s : color_late_s;
    const int millimeters = 1000 + event.frame;
    if (event.is_depth)
      bag.image(depth_topic, event.frame / 30.0 + depth_offset_s, "16UC1",
                {static_cast<std::uint8_t>(millimeters & 255), static_cast<std::uint8_t>(millimeters >> 8)});
    else
      bag.image(color_topic, event.frame / 30.0, "mono8", {50});
  }
}

std::vector<std::string> warnings_about(const Source& source, const std::string& what) {
  std::vector<std::string> found;
  for (const auto& warning : source.info().warnings)
    if (warning.find(what) != std::string::npos) found.push_back(warning);
  return found;
}

TEST(BagImages, DepthIsFoundByItsStampHoweverLateItWasRecorded) {
  for (const auto& [color_late_s, depth_late_s] :
       {std::pair(0.001, 0.002), std::pair(0.001, 0.042), std::pair(0.001, 0.102), std::pair(0.061, 0.002)}) {
    SCOPED_TRACE(testing::Message() << color_late_s << " " << depth_late_s);
    const ScratchFolder folder;
    write_delayed(folder.path("a.bag"), color_late_s, depth_late_s);
    const auto source = open(folder.path("a.bag"), with_depth());
    EXPECT_THAT(warnings_about(*source, "by their stamps"), IsEmpty());
    for (int k = 0; k < frame_count; ++k) {
      const auto frame = source->next();
      ASSERT_TRUE(frame);
      ASSERT_FALSE(frame->depth.empty()) << k;
      EXPECT_EQ(frame->depth_stamp, frame->stamp);
      EXPECT_NEAR(frame->depth.at(3, 2), 1.0F + static_cast<float>(k) * 1e-3F, 1e-6F);
    }
    EXPECT_FALSE(source->next());
  }
}

TEST(BagImages, DepthWhoseStampsNeverFitIsWarnedAbout) {
  const ScratchFolder folder;
  write_delayed(folder.path("a.bag"), 0.001, 0.002, 50.0);
  const auto source = open(folder.path("a.bag"), with_depth());
  EXPECT_THAT(warnings_about(*source, "by their stamps"),
              testing::ElementsAre("0 of the first 20 frames have a depth image of /camera/depth/image_raw within "
                                   "0.02 s by their stamps"));
  EXPECT_TRUE(source->next()->depth.empty());
}

TEST(BagImages, WithoutStampsInTheHeadersTheTimesOfRecordingAreThose) {
  const ScratchFolder folder;
  {
    BagWriter bag(folder.path("a.bag"));
    bag.has_stamps = false;
    for (int k = 0; k < 3; ++k) {
      bag.image(color_topic, k, "mono8", {50});
      bag.image(depth_topic, k + 0.004, "16UC1", {0xC4, 0x09});
    }
  }
  const auto source = open(folder.path("a.bag"), with_depth());
  for (int k = 0; k < 3; ++k) {
    const auto frame = source->next();
    EXPECT_EQ(frame->stamp, nanoseconds(at(k + 0.005)));
    EXPECT_EQ(frame->depth_stamp, nanoseconds(at(k + 0.009)));
    EXPECT_NEAR(frame->depth.at(0, 0), 2.5F, 1e-6F);
  }
}

TEST(BagImages, RegisteredDepthComesFirstWhereItIsWanted) {
  const ScratchFolder folder;
  for (const std::string registered : {"/camera/depth_registered/image_raw", "/camera/depth_z_aligned/image_raw"}) {
    {
      BagWriter bag(folder.path("a.bag"));
      bag.image(color_topic, 0, "mono8", {50});
      bag.image(depth_topic, 0, "16UC1", {0xE8, 0x03});  // 1000 mm
      bag.image(registered, 0, "16UC1", {0xD0, 0x07});   // 2000 mm
    }
    auto options = with_depth();
    const auto source = open(folder.path("a.bag"), options);
    EXPECT_THAT(source->info().warnings, Contains("topic " + registered + " is read, not /camera/depth/image_raw"));
    EXPECT_NEAR(source->next()->depth.at(0, 0), 2.0F, 1e-6F);
    options.raw_depth = true;
    EXPECT_NEAR(open(folder.path("a.bag"), options)->next()->depth.at(0, 0), 1.0F, 1e-6F);
  }
}

/// As compressed_depth_image_transport writes it.
std::vector<std::uint8_t> packed_depth_image(std::uint16_t value, float a, float b) {
  std::vector<std::uint8_t> file, bytes(12);
  cv::imencode(".png", cv::Mat(6, 8, CV_16UC1, cv::Scalar(value)), file);
  std::memcpy(bytes.data() + 4, &a, sizeof(a));
  std::memcpy(bytes.data() + 8, &b, sizeof(b));
  bytes.insert(bytes.end(), file.begin(), file.end());
  return bytes;
}

TEST(BagImages, CompressedDepthIsUnpacked) {
  const ScratchFolder folder;
  const std::string topic = std::string(depth_topic) + "/compressedDepth";
  const auto depth_at_pixel = [&](const std::string& format, const std::vector<std::uint8_t>& bytes) {
    {
      BagWriter bag(folder.path("a.bag"));
      bag.image(color_topic, 0, "mono8", {50});
      bag.packed(topic, 0, format, bytes);
    }
    const auto source = open(folder.path("a.bag"), with_depth());
    EXPECT_TRUE(source->info().has_depth);
    return source->next()->depth.at(7, 5);
  };
  EXPECT_NEAR(depth_at_pixel("16UC1; compressedDepth", packed_depth_image(1500, 0.0F, 0.0F)), 1.5F, 1e-6F);
  // 10000 / (5001 - 1)
  EXPECT_NEAR(depth_at_pixel("32FC1; compressedDepth png", packed_depth_image(5001, 10000.0F, 1.0F)), 2.0F, 1e-6F);
  EXPECT_EQ(depth_at_pixel("32FC1; compressedDepth png", packed_depth_image(0, 10000.0F, 1.0F)), 0.0F);
}

TEST(BagImages, DepthPackedInAnotherWayIsNamed) {
  const ScratchFolder folder;
  {
    BagWriter bag(folder.path("a.bag"));
    bag.packed("/camera/rgb/image_raw/compressed", 0, "mono8; png compressed", [] {
      std::vector<std::uint8_t> file;
      cv::imencode(".png", cv::Mat(6, 8, CV_8UC1, cv::Scalar(40)), file);
      return file;
    }());
    bag.packed("/a/compressedDepth", 0, "16UC1; compressedDepth rvl", std::vector<std::uint8_t>(60, 1));
  }
  const auto source = open(folder.path("a.bag"), with_depth());
  EXPECT_FALSE(source->info().has_depth);
  EXPECT_THAT(source->info().warnings, Contains("depth is not read from /a/compressedDepth: it is not packed as PNG"));
  EXPECT_EQ(source->next()->image.at(4, 4), 40);
}

TEST(BagImages, TheSizeOfTheImagesIsKnownBeforeTheyAreRead) {
  const ScratchFolder folder;
  for (const bool packed : {false, true}) {
    const std::string topic = packed ? "/camera/rgb/image_raw/compressed" : color_topic;
    std::vector<std::uint8_t> file;
    cv::imencode(".png", cv::Mat(6, 8, CV_8UC1, cv::Scalar(40)), file);
    for (const bool calibrated : {false, true}) {
      BagWriter bag(folder.path(calibrated ? "calibrated.bag" : "plain.bag"));
      if (calibrated) bag.camera_info("/camera/rgb/camera_info", 0, "plumb_bob", {0.0}, 16);
      if (packed)
        bag.packed(topic, 0, "png", file);
      else
        bag.image(topic, 0, "mono8", {50});
    }
    const auto plain = open(folder.path("plain.bag"), with_depth());
    ASSERT_TRUE(plain->info().cameras.front().camera);
    EXPECT_EQ(plain->info().cameras.front().camera->width, 8);
    EXPECT_EQ(plain->info().cameras.front().calibration_file, "--fov");
    const auto other = open(folder.path("calibrated.bag"));
    EXPECT_THAT(other->info().warnings, Contains(HasSubstr("the calibration is for images of 16x6, these are 8x6")));
    OpenOptions options;
    options.intrinsics = {{9.0, 9.0, 4.0, 3.0}};
    EXPECT_EQ(open(folder.path("plain.bag"), options)->info().cameras.front().camera->height, 6);
  }
}

TEST(BagImages, CalibrationsOfAllModelsAreRead) {
  const ScratchFolder folder;
  const auto source_of = [&](const std::string& model, const std::vector<double>& coefficients) {
    {
      BagWriter bag(folder.path("a.bag"));
      bag.camera_info("/camera/rgb/camera_info", 0, model, coefficients);
      bag.image(color_topic, 0, "mono8", {50});
    }
    return open(folder.path("a.bag"));
  };
  const auto camera = [&](const std::string& model, const std::vector<double>& coefficients) {
    return source_of(model, coefficients)->info().cameras.front().camera.value_or(Camera());
  };
  std::vector<double> rational = {0.1, 0.01, 0.001, 0.002, 0.003, 0.2, 0.02, 0.004, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(camera("rational_polynomial", rational).distortion, Distortion::rational);
  EXPECT_EQ(camera("rational_polynomial", rational).coefficients[7], 0.004);
  const auto brown = camera("plumb_bob", {0.1, 0.01, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(brown.distortion, Distortion::radial_tangential);
  EXPECT_EQ(brown.coefficients[1], 0.01);
  EXPECT_EQ(camera("plumb_bob", {0.1}).distortion, Distortion::radial_tangential);
  EXPECT_EQ(camera("equidistant", {0, 0, 0, 0}).distortion, Distortion::equidistant);
  EXPECT_EQ(camera("", {0, 0, 0, 0, 0}).distortion, Distortion::none);
  EXPECT_EQ(camera("", {0, 0, 0, 0, 0}).fy, 9.5);
  rational.back() = 0.5;
  for (const auto& source :
       {source_of("rational_polynomial", rational), source_of("thin_prism", {0.1, 0.01, 0, 0, 0})}) {
    EXPECT_FALSE(source->info().cameras.front().camera);
    EXPECT_THAT(source->info().warnings, Contains(AllOf(HasSubstr("the calibration in the bag is not used: "),
                                                        HasSubstr("/camera/rgb/camera_info"), Not(HasSubstr("\n")))));
  }
}

TEST(BagScans, WithoutALimitReachAHundredMeters) {
  const ScratchFolder folder;
  for (const float most : {std::numeric_limits<float>::infinity(), std::nanf(""), 0.0F, 30.0F}) {
    {
      BagWriter bag(folder.path("a.bag"));
      bag.scan("/scan", 0, most);
    }
    const auto frame = open(folder.path("a.bag"))->next();
    ASSERT_TRUE(frame && frame->scan);
    EXPECT_EQ(frame->scan->max_range, most == 30.0F ? 30.0 : 100.0);
    EXPECT_TRUE(frame->scan->is_return(0));
  }
}

}  // namespace
}  // namespace rastro

#endif
