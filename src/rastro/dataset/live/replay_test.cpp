// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/live/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "rastro/base/clock_testing.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/live/live.h"

namespace rastro {
namespace {

using testing::HasSubstr;

constexpr TimeNs ms = 1'000'000;

class Replay : public testing::Test {
 protected:
  void SetUp() override { write_euroc(folder_, 5); }  // 50 ms apart

  std::unique_ptr<LiveSource> replay(double speed = 1.0, bool loop = false) {
    OpenOptions options;
    options.read_ahead = 0;
    return open_live("replay:" + folder_.path(), options, {speed, loop}, clock_);
  }

  ScratchFolder folder_;
  FakeClock clock_;
};

TEST_F(Replay, GivesEachFrameWhenItsTimeHasCome) {
  for (const double speed : {1.0, 4.0}) {
    const auto source = replay(speed);
    const TimeNs begin = clock_.now();
    TimeNs first = 0;
    for (int k = 0; k < 5; ++k) {
      const auto arrived = source->next(1000 * ms);
      ASSERT_TRUE(arrived) << k;
      EXPECT_EQ(arrived->frame.index, k);
      if (k == 0) first = arrived->frame.stamp;
      EXPECT_EQ(arrived->frame.stamp, first + k * 50 * ms) << "stamps stay the recording's";
      EXPECT_EQ(arrived->exposed, begin + static_cast<TimeNs>(k * 50 * ms / speed));
      EXPECT_EQ(clock_.now(), arrived->exposed);
    }
    EXPECT_FALSE(source->next(1000 * ms));
    EXPECT_EQ(source->condition().state, LiveState::ended);
  }
}

TEST_F(Replay, WaitsNoLongerThanAsked) {
  const auto source = replay();
  ASSERT_TRUE(source->next(10 * ms));
  const TimeNs begin = clock_.now();
  for (int k = 0; k < 4; ++k) EXPECT_FALSE(source->next(10 * ms)) << k;
  EXPECT_EQ(clock_.now(), begin + 40 * ms);
  EXPECT_EQ(source->condition().state, LiveState::delivering);
  EXPECT_TRUE(source->next(10 * ms));
}

TEST_F(Replay, SlowsDownAndSaysSoWhereReadingIsTooSlow) {
  const auto source = replay();
  ASSERT_TRUE(source->next(ns_per_second));
  clock_.move(2 * ns_per_second);
  const auto late = source->next(ns_per_second);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->exposed, clock_.now()) << "no frame is older than its arrival";
  EXPECT_THAT(source->condition().line, HasSubstr("the replay is slower"));
  EXPECT_EQ(source->next(ns_per_second)->exposed, late->exposed + 50 * ms) << "the pace goes on from there";
}

TEST_F(Replay, LoopsWithStampsAndNumbersThatGoOn) {
  const auto source = replay(1.0, true);
  EXPECT_EQ(source->info().frame_count, -1);
  TimeNs first = 0;
  for (int k = 0; k < 13; ++k) {
    const auto arrived = source->next(ns_per_second);
    ASSERT_TRUE(arrived) << k;
    if (k == 0) first = arrived->frame.stamp;
    EXPECT_EQ(arrived->frame.index, k);
    EXPECT_EQ(arrived->frame.stamp, first + k * 50 * ms);
    EXPECT_EQ(arrived->frame.image.at(0, 0), 10 + k % 5);
  }
}

TEST_F(Replay, LoopsWithStampsThatGoOnAlsoWhereTheFirstFramesCannotBeRead) {
  for (const char* stamp : {"1400000000000000000", "1400000000050000000"})
    folder_.write(std::string("mav0/cam0/data/") + stamp + ".png", "no image");
  const auto source = replay(1.0, true);
  std::optional<TimeNs> last_stamp, last_exposed;
  int frames = 0, errors = 0;
  for (int k = 0; k < 20; ++k) {
    std::optional<ArrivedFrame> arrived;
    if (!error_of([&] { arrived = source->next(ns_per_second); }).empty()) {
      ++errors;
      continue;
    }
    ASSERT_TRUE(arrived) << k;
    if (last_stamp) {
      EXPECT_EQ(arrived->frame.stamp, *last_stamp + 50 * ms) << k;
      EXPECT_EQ(arrived->exposed, *last_exposed + 50 * ms) << k;
    }
    last_stamp = arrived->frame.stamp;
    last_exposed = arrived->exposed;
    ++frames;
  }
  EXPECT_EQ(frames, 12);
  EXPECT_EQ(errors, 8);
}

TEST_F(Replay, EndsALoopOverWhatIsGone) {
  const auto none_readable = replay(1.0, true);
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(none_readable->next(ns_per_second));
  for (int k = 0; k < 5; ++k)
    folder_.write("mav0/cam0/data/" + std::to_string(1'400'000'000'000'000'000 + k * 50 * ms) + ".png", "no image");
  for (int k = 0; k < 5; ++k) EXPECT_NE(error_of([&] { none_readable->next(ns_per_second); }), "") << k;
  EXPECT_FALSE(none_readable->next(ns_per_second));
  EXPECT_EQ(none_readable->condition().state, LiveState::ended);

  write_euroc(folder_, 1);
  const auto removed = replay(1.0, true);
  ASSERT_TRUE(removed->next(ns_per_second));
  std::filesystem::remove_all(folder_.path());
  EXPECT_NE(error_of([&] { removed->next(ns_per_second); }), "");
  EXPECT_FALSE(removed->next(ns_per_second));
  EXPECT_EQ(removed->condition().state, LiveState::ended);
}

TEST_F(Replay, RefusesWhatItCannotReplay) {
  const auto refused = [this](const std::string& address, double speed) {
    return error_of([&] { open_live(address, {}, {speed, false}, clock_); });
  };
  EXPECT_THAT(refused("replay:" + folder_.path(), 0.0), HasSubstr("--speed"));
  EXPECT_THAT(refused("replay:" + folder_.path(), std::nan("")), HasSubstr("--speed"));
  EXPECT_THAT(refused("replay:", 1.0), HasSubstr("names no recording"));
  EXPECT_THAT(refused("replay:" + folder_.path("nothing"), 1.0), HasSubstr("nothing"));
  EXPECT_FALSE(is_live(folder_.path()));
}

}  // namespace
}  // namespace rastro
