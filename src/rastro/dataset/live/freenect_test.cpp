// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/freenect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <deque>

#include "rastro/base/clock_testing.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/registered_depth.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr TimeNs ms = 1'000'000;
constexpr std::uint32_t ticks_per_ms = 60'000;

/// Plays a Kinect: images of one color and depth with their ticks.
struct FakeKinect {
  struct Image {
    bool is_color = true;
    std::uint32_t ticks = 0;
    int value = 0;
  };
  std::deque<Image> images;
  bool is_connected = true, is_registered = false;
  int open = 0;

  void add(std::uint32_t color_ms, std::uint32_t depth_ms, int value, std::uint32_t begin = 0) {
    images.push_back({false, begin + depth_ms * ticks_per_ms, value});
    images.push_back({true, begin + color_ms * ticks_per_ms, value});
  }
};

class FakeCamera final : public FreenectCamera {
 public:
  FakeCamera(FakeKinect& kinect, FakeClock& clock) : kinect_(kinect), clock_(clock) { ++kinect_.open; }
  ~FakeCamera() override { --kinect_.open; }
  bool wait(TimeNs at_most) override {
    clock_.sleep_for(std::min(at_most, 5 * ms));
    if (!kinect_.is_connected) return false;
    if (kinect_.images.empty()) return true;
    now_ = kinect_.images.front();
    kinect_.images.pop_front();
    return true;
  }
  std::optional<FreenectImage> take_color() override { return take(true); }
  std::optional<FreenectImage> take_depth() override { return take(false); }

 private:
  std::optional<FreenectImage> take(bool color) {
    if (!now_ || now_->is_color != color) return std::nullopt;
    FreenectImage image;
    image.ticks = now_->ticks;
    image.bytes.resize(640U * 480U * (color ? 3U : 2U), static_cast<std::uint8_t>(now_->value));
    const auto millimeters = static_cast<std::uint16_t>(1000 + now_->value);
    if (!color)
      for (std::size_t k = 4; k < image.bytes.size(); k += 2) std::memcpy(&image.bytes[k], &millimeters, 2);
    if (!color) std::memset(image.bytes.data(), 0, 4);
    now_.reset();
    return image;
  }

  FakeKinect& kinect_;
  FakeClock& clock_;
  std::optional<FakeKinect::Image> now_;
};

class FakeSystem final : public FreenectSystem {
 public:
  FakeSystem(FakeKinect& kinect, FakeClock& clock) : kinect_(kinect), clock_(clock) {}
  std::vector<std::string> serials() override { return {"A00"}; }
  std::unique_ptr<FreenectCamera> open(int number, bool registered) override {
    if (number != 0 || !kinect_.is_connected) return nullptr;
    kinect_.is_registered = registered;
    return std::make_unique<FakeCamera>(kinect_, clock_);
  }

 private:
  FakeKinect& kinect_;
  FakeClock& clock_;
};

class Freenect : public testing::Test {
 protected:
  std::unique_ptr<LiveSource> camera(const OpenOptions& options = {}, const std::string& number = "0") {
    return open_freenect("freenect:" + number, number, options, &system_, clock_);
  }
  std::optional<ArrivedFrame> next(LiveSource& source) {
    for (int k = 0; k < 20; ++k)
      if (auto arrived = source.next(50 * ms)) return arrived;
    return std::nullopt;
  }

  FakeClock clock_;
  FakeKinect kinect_;
  FakeSystem system_{kinect_, clock_};
};

TEST_F(Freenect, ColorComesWithTheDepthOfTheNearestStamp) {
  kinect_.images.push_back({false, 3 * ticks_per_ms, 1});  // too early
  kinect_.add(100, 90, 20);
  kinect_.add(133, 140, 30);
  const auto source = camera();
  EXPECT_TRUE(kinect_.is_registered);
  EXPECT_TRUE(source->info().has_depth);
  EXPECT_NEAR(source->info().cameras.front().camera->fx, 525.0, 1.0);
  const auto first = next(*source), second = next(*source);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->frame.image.at(7, 9), 20);
  EXPECT_EQ(first->frame.depth.at(0, 0), 0.0F) << "0 is none";
  EXPECT_NEAR(first->frame.depth.at(5, 3), 1.020F, 1e-6F);
  EXPECT_EQ(first->frame.depth_stamp - first->frame.stamp, -10 * ms);
  EXPECT_EQ(second->frame.stamp - first->frame.stamp, 33 * ms);
  EXPECT_EQ(second->frame.depth_stamp - second->frame.stamp, 7 * ms);
}

TEST_F(Freenect, TheClockOfTheCameraGoesRound) {
  const std::uint32_t begin = 0xFFFFFFFF - 50 * ticks_per_ms;
  for (std::uint32_t k = 0; k < 4; ++k) kinect_.add(33 * k, 33 * k + 2, 10, begin);
  const auto source = camera();
  std::vector<TimeNs> stamps;
  while (const auto arrived = next(*source)) stamps.push_back(arrived->frame.stamp);
  ASSERT_EQ(stamps.size(), 4U);
  for (std::size_t k = 1; k < 4; ++k) EXPECT_EQ(stamps[k] - stamps[k - 1], 33 * ms);
}

TEST_F(Freenect, AKinectThatIsUnpluggedIsWaitedFor) {
  kinect_.add(0, 0, 10);
  const auto source = camera();
  ASSERT_TRUE(next(*source));
  kinect_.is_connected = false;
  EXPECT_FALSE(next(*source));
  EXPECT_EQ(source->condition().state, LiveState::gone);
  EXPECT_EQ(kinect_.open, 0);
  kinect_.is_connected = true;
  kinect_.add(500, 500, 11);
  EXPECT_TRUE(next(*source));
  EXPECT_EQ(source->condition().state, LiveState::delivering);
}

TEST_F(Freenect, DepthIsCorrectedAndRegisteredAsItWasCalibrated) {
  const ScratchFolder folder;
  const std::string color =
      "image_width: 640\nimage_height: 480\ncamera_matrix: [525, 0, 320, 0, 525, 240, 0, 0, 1]\n"
      "distortion_model: plumb_bob\ndistortion_coefficients: [0, 0, 0, 0, 0]\ndepth_factor: 800\n"
      "depth_offset_m: 0.01\n";
  folder.write("plain.yaml", color);
  folder.write("beside.yaml", color +
                                  "depth_camera:\n  image_width: 640\n  image_height: 480\n"
                                  "  camera_matrix: [525, 0, 320, 0, 525, 240, 0, 0, 1]\n"
                                  "color_from_depth: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1]\n");
  OpenOptions options;
  options.want_depth = true;
  options.calibration_file = folder.path("plain.yaml");
  kinect_.add(0, 0, 20);
  EXPECT_NEAR(next(*camera(options))->frame.depth.at(300, 200), 1.285F, 1e-6F);
  EXPECT_TRUE(kinect_.is_registered);
  options.calibration_file = folder.path("beside.yaml");
  kinect_.images.clear();
  kinect_.add(0, 0, 20);
  const auto source = registered_depth(camera(options), options);
  EXPECT_FALSE(kinect_.is_registered) << "rastro does it";
  EXPECT_NEAR(next(*source)->frame.depth.at(300, 200), 1.785F, 1e-5F);
  options.raw_depth = true;
  kinect_.add(33, 33, 20);
  EXPECT_NEAR(next(*registered_depth(camera(options), options))->frame.depth.at(300, 200), 1.285F, 1e-6F);
}

TEST_F(Freenect, TheDepthFactorOfOtherRecordingsIsNotUsedAndNamed) {
  const ScratchFolder folder;
  folder.write("tum.yaml",
               "image_width: 640\nimage_height: 480\ncamera_matrix: [525, 0, 320, 0, 525, 240, 0, 0, 1]\n"
               "depth_factor: 5000\n");
  OpenOptions options;
  options.want_depth = true;
  options.calibration_file = folder.path("tum.yaml");
  kinect_.add(0, 0, 20);
  const auto source = camera(options);
  EXPECT_THAT(source->info().warnings, Contains(HasSubstr("depth_factor 5000 is not used")));
  EXPECT_EQ(source->info().depth_factor, 1000.0);
  EXPECT_NEAR(next(*source)->frame.depth.at(300, 200), 1.02F, 1e-6F);
}

TEST_F(Freenect, WhatCannotBeOpenedSaysWhatToDo) {
  EXPECT_THAT(error_of([&] { camera({}, "1"); }), HasSubstr("is it connected"));
  EXPECT_THAT(error_of([&] { camera({}, "x"); }), HasSubstr("freenect:0"));
  EXPECT_THAT(error_of([&] { open_freenect("freenect:0", "0", {}, nullptr, clock_); }),
              HasSubstr("RASTRO_WITH_FREENECT"));
}

}  // namespace
}  // namespace rastro
