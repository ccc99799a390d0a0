// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "rastro/dataset/check.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"
#include "rastro/dataset/recording.h"

namespace rastro {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr TimeNs ms = 1'000'000;

/// Twelve frames, 33 ms apart, but the seventh comes after a second; the last three are 50 ms apart.
const std::vector<std::int64_t> phone_ms = {0, 33, 66, 99, 132, 165, 1165, 1198, 1231, 1281, 1331, 1381};

std::vector<Frame> read_all(const std::string& path, const OpenOptions& options = {}) {
  const auto source = open(path, options);
  std::vector<Frame> frames;
  while (auto frame = source->next()) frames.push_back(std::move(*frame));
  return frames;
}

class Video : public testing::Test {
 protected:
  void SetUp() override {
    write_matroska(folder_, "phone.mkv", phone_ms);
    if (error_of([&] { open(path_); }).find("does not read videos") != std::string::npos)
      GTEST_SKIP() << "built without videos";
  }

  ScratchFolder folder_;
  std::string path_ = folder_.path("phone.mkv");
};

TEST_F(Video, StampsArePresentationTimes) {
  const auto frames = read_all(path_);
  ASSERT_EQ(frames.size(), phone_ms.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    EXPECT_EQ(frames[k].stamp, phone_ms[k] * ms);
    EXPECT_NEAR(frames[k].image.at(4, 3), 10 + 10 * static_cast<int>(k), 3) << "the image is of this stamp";
  }
  OpenOptions options;
  options.rate_hz = 10.0;
  EXPECT_EQ(read_all(path_, options)[7].stamp, 700 * ms) << "a given rate beats the file";
}

TEST_F(Video, ChosenFramesKeepTheirStampsWhereTheNumberOfFramesIsNotKnown) {
  OpenOptions options;
  options.first_frame = 2;
  options.every = 4;
  const auto frames = read_all(path_, options);
  ASSERT_EQ(frames.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(frames[k].index, static_cast<std::int64_t>(2 + 4 * k));
    EXPECT_EQ(frames[k].stamp, phone_ms[2 + 4 * k] * ms);
  }
}

TEST_F(Video, CheckReportsTheHole) {
  const auto report = check(path_, {});
  EXPECT_EQ(report.frames_read, 12);
  ASSERT_GE(report.stamps.gaps.size(), 1U);
  EXPECT_EQ(report.stamps.gaps[0].after_frame, 5);
  EXPECT_NEAR(report.stamps.gaps[0].seconds, 1.0, 1e-9);
  EXPECT_TRUE(report.usable);
  EXPECT_THAT(report.warnings, Not(Contains(HasSubstr("the video ends after"))));
}

TEST_F(Video, TimesThatDoNotRiseAreReplaced) {
  write_matroska(folder_, "still.mkv", {0, 0, 0, 0});
  const auto frames = read_all(folder_.path("still.mkv"));
  ASSERT_EQ(frames.size(), 4U);
  for (std::size_t k = 1; k < frames.size(); ++k) EXPECT_GT(frames[k].stamp, frames[k - 1].stamp);
}

TEST(FrameChoiceOfAnyLength, DoesNotOverflow) {
  constexpr auto endless = std::numeric_limits<std::int64_t>::max();
  OpenOptions options;
  for (const int every : {1, 2, 3, 1000, std::numeric_limits<int>::max()}) {
    options.every = every;
    const FrameChoice choice(options, endless, "video");
    EXPECT_EQ(choice.count, (endless - 1) / every + 1) << every;
    EXPECT_EQ(FrameChoice(options, 10, "ten").count, (9 / every) + 1) << every;
  }
}

constexpr const char* camchain = R"(cam0:
  camera_model: pinhole
  intrinsics: [6.0, 6.0, 3.5, 2.5]
  distortion_model: radtan
  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]
  resolution: [8, 6]
cam1:
  camera_model: pinhole
  intrinsics: [7.0, 7.0, 3.5, 2.5]
  distortion_model: radtan
  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]
  resolution: [8, 6]
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.1]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
)";
constexpr const char* pair_of_opencv =
    "%YAML:1.0\n---\n"
    "M1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 6., 0., 3.5, 0., 6., 2.5, 0., 0., 1. ]\n"
    "D1: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n   data: [ 0., 0., 0., 0. ]\n"
    "M2: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 7., 0., 3.5, 0., 7., 2.5, 0., 0., 1. ]\n"
    "D2: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n   data: [ 0., 0., 0., 0. ]\n";

void choose_each_camera(const std::string& data, const std::string& calibration, const std::string& first,
                        const std::string& second) {
  OpenOptions options;
  options.calibration_file = calibration;
  const auto info = open(data, options)->info();
  ASSERT_EQ(info.cameras.size(), 1U);
  ASSERT_TRUE(info.cameras[0].camera);
  EXPECT_EQ(info.cameras[0].camera->fx, 6.0);
  EXPECT_EQ(info.cameras[0].name, first);
  EXPECT_THAT(info.warnings, Contains(AllOf(HasSubstr(first + ", " + second), HasSubstr(first + " is used"))));
  options.camera = second;
  const auto other = open(data, options)->info();
  EXPECT_EQ(other.cameras.front().camera->fx, 7.0);
  EXPECT_THAT(other.warnings, Not(Contains(HasSubstr("is used"))));
  options.camera = "cam7";
  EXPECT_THAT(error_of([&] { open(data, options); }), HasSubstr("has " + first + ", " + second + ", but not cam7"));
}

TEST_F(Video, TakesACameraOfSeveral) {
  folder_.write("chain.yaml", camchain);
  folder_.write("pair.yml", pair_of_opencv);
  choose_each_camera(path_, folder_.path("chain.yaml"), "cam0", "cam1");
  choose_each_camera(path_, folder_.path("pair.yml"), "left", "right");
  OpenOptions options;
  options.camera = "cam1";
  EXPECT_THAT(error_of([&] { open(path_, options); }), HasSubstr("no named cameras"));
}

TEST(ImagesWithCalibration, TakeACameraOfSeveral) {
  const ScratchFolder folder;
  folder.write_gray("a/1.png", 10);
  folder.write_gray("a/2.png", 20);
  folder.write("chain.yaml", camchain);
  folder.write("pair.yml", pair_of_opencv);
  choose_each_camera(folder.path("a"), folder.path("chain.yaml"), "cam0", "cam1");
  choose_each_camera(folder.path("a"), folder.path("pair.yml"), "left", "right");
  OpenOptions options;
  options.camera = "cam1";
  EXPECT_THAT(error_of([&] { open(folder.path("a"), options); }), HasSubstr("no named cameras"));
  folder.write("a/camchain.yaml", camchain);
  EXPECT_EQ(open(folder.path("a"), options)->info().cameras.front().camera->fx, 7.0) << "found beside the images";
}

}  // namespace
}  // namespace rastro
