// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/live_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/clock_testing.h"
#include "rastro/dataset/dataset_testing.h"

namespace rastro {
namespace {

using testing::HasSubstr;

constexpr TimeNs ms = 1'000'000;

/// How a device behaves: gives so many images, 33 ms apart, then is gone or silent.
struct Behavior {
  int images = 3;
  bool is_silent_then = false;
  int width = 8;
};

class FakeDevice final : public CameraDevice {
 public:
  FakeDevice(const Behavior& behavior, FakeClock& clock) : behavior_(behavior), clock_(clock) {}
  std::optional<ArrivedFrame> next(TimeNs patience) override {
    if (behavior_.images-- > 0) {
      clock_.move(33 * ms);
      ArrivedFrame arrived;
      arrived.frame.image = GrayImage(behavior_.width, 6);
      arrived.exposed = arrived.frame.stamp = clock_.now();
      return arrived;
    }
    if (!behavior_.is_silent_then) throw DeviceGone("/dev/video0: unplugged");
    clock_.sleep_for(patience);
    return std::nullopt;
  }

 private:
  Behavior behavior_;
  FakeClock& clock_;
};

class Camera : public testing::Test {
 protected:
  std::unique_ptr<LiveSource> camera(const Behavior& behavior, const OpenOptions& choice = {}) {
    return make_live_camera(
        camera_info("v4l2:/dev/video0", "live_v4l2", ImageSize{8, 6}, choice),
        std::make_unique<FakeDevice>(behavior, clock_), [this] { return reopen(); }, choice, {}, clock_);
  }

  std::unique_ptr<CameraDevice> reopen() {
    if (refusals_-- > 0) throw Error("/dev/video0: is not there");
    refusals_ = 4;
    ++opened_;
    return std::make_unique<FakeDevice>(next_, clock_);
  }

  FakeClock clock_;
  Behavior next_;
  int refusals_ = 4, opened_ = 0;
};

TEST_F(Camera, DiesAndReturnsTwentyTimesAndGoesOn) {
  const auto source = camera({});
  std::int64_t frames = 0;
  int losses = 0;
  LiveState last = LiveState::delivering;
  while (opened_ < 20 || frames < 63) {
    if (const auto arrived = source->next(50 * ms)) {
      EXPECT_EQ(arrived->frame.index, frames++);
    }
    const LiveCondition condition = source->condition();
    losses += condition.state == LiveState::gone && last != LiveState::gone ? 1 : 0;
    if (condition.state == LiveState::gone) {
      EXPECT_THAT(condition.line, HasSubstr("/dev/video0"));
    }
    last = condition.state;
  }
  EXPECT_EQ(losses, 20);
  EXPECT_EQ(frames, 63);
  EXPECT_EQ(last, LiveState::delivering);
}

TEST_F(Camera, IsTriedAgainAtIntervalsOnly) {
  const auto source = camera({0, false, 8});
  source->next(50 * ms);
  EXPECT_EQ(source->condition().state, LiveState::gone);
  const TimeNs begin = clock_.now();
  while (opened_ == 0) source->next(50 * ms);
  EXPECT_GE(clock_.now() - begin, 5 * ns_per_second / 2) << "four refusals, half a second apart";
  EXPECT_LE(clock_.now() - begin, 3 * ns_per_second);
}

TEST_F(Camera, IsStalledWhenNothingComes) {
  const auto source = camera({1, true, 8});
  EXPECT_TRUE(source->next(50 * ms));
  for (int k = 0; k < 39; ++k) EXPECT_FALSE(source->next(50 * ms));
  EXPECT_EQ(source->condition().state, LiveState::delivering);
  for (int k = 0; k < 3; ++k) source->next(50 * ms);
  EXPECT_EQ(source->condition().state, LiveState::stalled);
  EXPECT_THAT(source->condition().line, HasSubstr("no image for 2 s"));
}

TEST_F(Camera, GivesTheChosenFramesAndEnds) {
  OpenOptions choice;
  choice.first_frame = 2;
  choice.end_frame = 7;
  choice.every = 2;
  const auto source = camera({100, false, 8}, choice);
  std::vector<std::int64_t> indices;
  while (source->condition().state != LiveState::ended)
    if (const auto arrived = source->next(50 * ms)) indices.push_back(arrived->frame.index);
  EXPECT_EQ(indices, (std::vector<std::int64_t>{2, 4, 6}));
}

TEST_F(Camera, RefusesAnotherSizeAfterItsReturn) {
  refusals_ = 0;
  next_.width = 16;
  const auto source = camera({1, false, 8});
  EXPECT_TRUE(source->next(50 * ms));
  source->next(50 * ms);
  const std::string line = error_of([&] {
    for (int k = 0; k < 100; ++k) source->next(50 * ms);
  });
  EXPECT_THAT(line, HasSubstr("16x6, but those before it 8x6"));
}

}  // namespace
}  // namespace rastro
