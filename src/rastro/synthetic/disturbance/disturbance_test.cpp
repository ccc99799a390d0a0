// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/disturbance/disturbance.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using testing::HasSubstr;

constexpr int image_width = 4, image_height = 3, frame_count = 6;

/// Every sensor at 10 Hz; all values tell the number of the frame.
class EverySensor : public Source {
 public:
  explicit EverySensor(bool complete = true) {
    if (!complete) return;
    info_.has_depth = info_.has_right = info_.has_scan = info_.has_odometry = true;
    Camera camera;
    camera.fx = camera.fy = 100.0;
    info_.cameras.push_back({"cam0", camera, std::nullopt, "generated"});
    info_.left_from_right = SE3(SO3(), {0.1, 0.0, 0.0});
  }
  const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    if (next_ >= frame_count) return std::nullopt;
    Frame frame;
    frame.index = next_;
    frame.stamp = frame.depth_stamp = next_ * 100'000'000;
    frame.image = filled(100 + next_);
    frame.right = filled(200 + next_);
    frame.color.rgb = Image<std::uint8_t>(3 * image_width, image_height);
    for (int x = 0; x < 3 * image_width; ++x) frame.color.rgb.at(x, 0) = 50;
    frame.depth = DepthImage(image_width, image_height);
    for (int x = 1; x < image_width; ++x) frame.depth.at(x, 0) = static_cast<float>(x + 10 * next_);
    const auto range = static_cast<float>(next_);
    frame.scan = LaserScan{0.0, 0.1, 0.05, 10.0, {range, range + 0.5F}, SE2()};
    frame.odometry_from_body = SE2(SO2(), {static_cast<double>(next_), 0.0});
    ++next_;
    return frame;
  }

 private:
  static GrayImage filled(int value) {
    GrayImage image(image_width, image_height);
    for (int y = 0; y < image_height; ++y)
      for (int x = 0; x < image_width; ++x) image.at(x, y) = static_cast<std::uint8_t>(value);
    return image;
  }

  SourceInfo info_;
  int next_ = 0;
};

std::vector<Frame> frames_with(const std::string& assignment) {
  const auto source = disturbed(std::make_unique<EverySensor>(), assignment);
  std::vector<Frame> frames;
  while (auto frame = source->next()) frames.push_back(std::move(*frame));
  return frames;
}

SourceInfo info_with(const std::string& assignment) {
  return disturbed(std::make_unique<EverySensor>(), assignment)->info();
}

std::string error_with(const std::string& assignment, bool complete = true) {
  try {
    disturbed(std::make_unique<EverySensor>(complete), assignment);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Disturbance, NoneLeavesTheRecordingAsItIs) {
  const auto frames = frames_with("none");
  ASSERT_EQ(frames.size(), 6U);
  EXPECT_EQ(frames[3].image.at(1, 1), 103);
  EXPECT_EQ(frames[3].odometry_from_body->translation().x(), 3.0);
}

TEST(Disturbance, BlackFramesHaveNeitherLightNorDepth) {
  const auto frames = frames_with("black=2:4");
  EXPECT_EQ(frames[1].image.at(0, 0), 101);
  for (const std::size_t k : {2U, 3U}) {
    EXPECT_EQ(frames[k].image.at(3, 2), 0);
    EXPECT_EQ(frames[k].right.at(0, 0), 0);
    EXPECT_EQ(frames[k].color.rgb.at(0, 0), 0);
    EXPECT_EQ(frames[k].depth.at(2, 0), 0.0F);
    EXPECT_EQ(frames[k].image.width(), image_width);
  }
  EXPECT_EQ(frames[4].depth.at(1, 0), 41.0F);
}

TEST(Disturbance, FrozenFramesRepeatTheOneBefore) {
  const auto frames = frames_with("freeze=2:4");
  EXPECT_EQ(frames[3].image.at(0, 0), 101);
  EXPECT_EQ(frames[3].depth.at(1, 0), 11.0F);
  EXPECT_EQ(frames[3].scan->ranges[0], 1.0F);
  EXPECT_EQ(frames[3].stamp, 300'000'000);
  EXPECT_EQ(frames[4].image.at(0, 0), 104);
  EXPECT_EQ(frames_with("freeze=0:2")[1].image.at(0, 0), 100) << "nothing is before frame 0: it is repeated itself";
}

TEST(Disturbance, DroppedFramesAreMissing) {
  const auto frames = frames_with("drop=1:4");
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[1].index, 4);
}

TEST(Disturbance, NoiseIsTheSameOnEveryRun) {
  const auto frames = frames_with("noise=5"), again = frames_with("noise=5");
  int differences = 0;
  for (int x = 0; x < image_width; ++x) {
    EXPECT_EQ(frames[1].image.at(x, 1), again[1].image.at(x, 1));
    EXPECT_LT(std::abs(frames[1].image.at(x, 1) - 101), 30);
    differences += frames[1].image.at(x, 1) != 101 ? 1 : 0;
  }
  EXPECT_GT(differences, 0);
  EXPECT_EQ(frames_with("noise=0")[1].image.at(1, 1), 101);
}

TEST(Disturbance, BlurIsTheMeanAlongARow) {
  // The red of row 0 is 50 throughout, row 1 is black: blur along rows changes neither.
  EXPECT_EQ(frames_with("blur=4")[0].color.rgb.at(5, 0), 50);
  EXPECT_EQ(frames_with("blur=4")[0].color.rgb.at(5, 1), 0);
  class Edge : public EverySensor {
   public:
    std::optional<Frame> next() override {
      auto frame = EverySensor::next();
      if (frame) frame->image.at(0, 0) = frame->image.at(1, 0) = 0;
      return frame;
    }
  };
  const auto frame = disturbed(std::make_unique<Edge>(), "blur=2")->next();
  EXPECT_EQ(frame->image.at(1, 0), 0);
  EXPECT_EQ(frame->image.at(2, 0), 50) << "half of 0 and half of 100";
  EXPECT_EQ(frame->image.at(3, 0), 100);
}

TEST(Disturbance, DarkImagesHaveLessLightAndTheNoiseStays) {
  const auto frames = frames_with("dark=4"), again = frames_with("dark=4");
  double sum = 0.0;
  for (int x = 0; x < image_width; ++x) {
    sum += frames[2].image.at(x, 1);
    EXPECT_EQ(frames[2].image.at(x, 1), again[2].image.at(x, 1));
  }
  EXPECT_NEAR(sum / image_width, 102.0 / 4.0, 3.0);
}

TEST(Disturbance, CrowdCoversItsShareInFrontOfEverything) {
  class Wide : public Source {
   public:
    const SourceInfo& info() const override { return info_; }
    std::optional<Frame> next() override {
      if (next_ == 200) return std::nullopt;
      Frame frame;
      frame.index = next_++;
      frame.image = GrayImage(100, 4);
      frame.depth = DepthImage(100, 4);
      return frame;
    }

   private:
    SourceInfo info_;
    int next_ = 0;
  };
  const auto source = disturbed(std::make_unique<Wide>(), "crowd=0.3");
  double covered = 0.0;
  while (const auto frame = source->next()) {
    for (int x = 0; x < 100; ++x) {
      EXPECT_EQ(frame->image.at(x, 2) > 0, frame->depth.at(x, 2) == 1.0F);
      covered += frame->depth.at(x, 2) == 1.0F ? 1.0 : 0.0;
    }
  }
  EXPECT_NEAR(covered / 20'000.0, 0.3, 0.08) << "they hide each other where they meet";
}

TEST(Disturbance, ColorCastScalesRedAlone) {
  const auto frames = frames_with("color-cast=0.5");
  EXPECT_EQ(frames[0].color.rgb.at(3, 0), 25);
  EXPECT_EQ(frames[0].color.rgb.at(4, 0), 50);
}

TEST(Disturbance, PairIsSwappedOrOutOfStep) {
  const auto swapped = frames_with("swap-stereo");
  EXPECT_EQ(swapped[2].image.at(0, 0), 202);
  EXPECT_EQ(swapped[2].right.at(0, 0), 102);
  const auto late = frames_with("late-right=2");
  EXPECT_EQ(late[5].right.at(0, 0), 203);
  EXPECT_EQ(late[1].right.at(0, 0), 200) << "before frame N there is nothing older than the first";
  EXPECT_EQ(late[5].image.at(0, 0), 105);
}

TEST(Disturbance, CalibrationIsScaled) {
  EXPECT_NEAR(info_with("baseline=10").left_from_right->translation().x(), 1.0, 1e-12);
  EXPECT_EQ(info_with("focal-length=0.5").cameras.front().camera->fx, 50.0);
  EXPECT_EQ(info_with("focal-length").cameras.front().camera->fy, 50.0) << "the default is 0.5";
}

TEST(Disturbance, DepthIsMirroredScaledConstantOrLate) {
  EXPECT_EQ(frames_with("mirror-depth")[1].depth.at(0, 0), 13.0F);
  EXPECT_EQ(frames_with("depth-scale=2")[1].depth.at(3, 0), 26.0F);
  const auto constant = frames_with("constant-depth=1.5");
  EXPECT_EQ(constant[1].depth.at(3, 0), 1.5F);
  EXPECT_EQ(constant[1].depth.at(0, 0), 0.0F) << "what was not measured stays so";
  const auto late = frames_with("late-depth=0.2");
  EXPECT_EQ(late[5].depth.at(1, 0), 31.0F);
  EXPECT_EQ(late[1].depth.at(1, 0), 1.0F);
  EXPECT_EQ(late[5].depth_stamp, 500'000'000) << "the wrong image claims the right time";
}

TEST(Disturbance, ScansAreStuckReversedOrScaled) {
  const auto stuck = frames_with("stuck-scan=2");
  EXPECT_EQ(stuck[1].scan->ranges[0], 1.0F);
  EXPECT_EQ(stuck[5].scan->ranges[0], 2.0F);
  EXPECT_EQ(frames_with("reverse-beams")[1].scan->ranges[0], 1.5F);
  const auto scaled = frames_with("range-scale=2");
  EXPECT_EQ(scaled[3].scan->ranges[1], 7.0F);
  EXPECT_EQ(scaled[3].scan->max_range, 20.0);
}

TEST(Disturbance, OdometryRunsBackward) {
  const auto frames = frames_with("reverse-odometry");
  EXPECT_NEAR(frames[0].odometry_from_body->translation().x(), 0.0, 1e-12);
  EXPECT_NEAR(frames[4].odometry_from_body->translation().x(), -4.0, 1e-12);
}

TEST(Disturbance, WrongAssignmentsAreRefused) {
  EXPECT_THAT(error_with("swap-stero"), HasSubstr("did you mean 'swap-stereo'"));
  EXPECT_THAT(error_with("mirror-depth=2"), HasSubstr("has no value"));
  EXPECT_THAT(error_with("black"), HasSubstr("give black=A:B"));
  EXPECT_THAT(error_with("black=4:2"), HasSubstr("not a range of frames"));
  EXPECT_THAT(error_with("drop=4"), HasSubstr("not a range of frames"));
  EXPECT_THAT(error_with("baseline=-1"), HasSubstr("not a factor"));
  EXPECT_THAT(error_with("noise=much"), HasSubstr("not an amount"));
  EXPECT_THAT(error_with("late-right=1.5"), HasSubstr("whole number"));
}

TEST(Disturbance, WhatIsNotThereCannotBeDisturbed) {
  EXPECT_THAT(error_with("swap-stereo", false), HasSubstr("no right images"));
  EXPECT_THAT(error_with("late-depth", false), HasSubstr("no depth"));
  EXPECT_THAT(error_with("stuck-scan", false), HasSubstr("no laser scans"));
  EXPECT_THAT(error_with("reverse-odometry", false), HasSubstr("no wheel odometry"));
  EXPECT_THAT(error_with("focal-length", false), HasSubstr("no calibrated camera"));
}

TEST(Disturbance, WarningsAreDueWhereTheInputContradictsItself) {
  EXPECT_EQ(warning_due("baseline=10"), WarningDue::yes);
  EXPECT_EQ(warning_due("noise=5"), WarningDue::no);
  EXPECT_EQ(warning_due("black=1:2"), WarningDue::either);
}

TEST(Disturbance, EveryKindIsDocumentedAndCanBeMade) {
  for (const DisturbanceKind& kind : disturbance_kinds()) {
    EXPECT_FALSE(kind.summary.empty()) << kind.name;
    const bool needs_value = !kind.value.empty() && kind.default_value.empty();
    EXPECT_NO_THROW(check_disturbance(kind.name + (needs_value ? "=1:2" : ""))) << kind.name;
  }
}

}  // namespace
}  // namespace rastro
