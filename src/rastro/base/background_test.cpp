// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/background.h"

#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

namespace rastro {
namespace {

class BackgroundTest : public testing::TestWithParam<bool> {};

TEST_P(BackgroundTest, RunsJobsInTheirOrderAndWaitSeesWhatTheyWrote) {
  Background background(GetParam());
  std::vector<int> order;
  for (int k = 0; k < 100; ++k) {
    const std::size_t job = background.submit([&order, k] { order.push_back(k); });
    EXPECT_EQ(job, static_cast<std::size_t>(k) + 1);
    if (k % 10 != 9) continue;
    background.wait(job);
    EXPECT_EQ(order.size(), static_cast<std::size_t>(k) + 1);
    EXPECT_EQ(order.back(), k);
  }
}

TEST_P(BackgroundTest, AnExceptionIsThrownByWaitAndStopsLaterJobs) {
  Background background(GetParam());
  int ran = 0;
  const std::size_t good = background.submit([&] { ++ran; });
  const std::size_t bad = background.submit([] { throw std::runtime_error("no room"); });
  const std::size_t after = background.submit([&] { ++ran; });
  EXPECT_NO_THROW(background.wait(good));
  EXPECT_THROW(background.wait(bad), std::runtime_error);
  EXPECT_THROW(background.wait(after), std::runtime_error);
  EXPECT_THROW(background.wait_for_all(), std::runtime_error);
  EXPECT_EQ(ran, 1);
}

TEST_P(BackgroundTest, AJobIsDoneAfterWaitAndNotBeforeItMayRun) {
  std::mutex held;
  Background background(GetParam());
  std::unique_lock lock(held, std::defer_lock);
  if (GetParam()) lock.lock();
  const std::size_t job = background.submit([&] { const std::lock_guard wait(held); });
  EXPECT_EQ(background.is_done(job), !GetParam());
  EXPECT_FALSE(background.is_done(job + 1));
  if (GetParam()) lock.unlock();
  background.wait(job);
  EXPECT_TRUE(background.is_done(job));
}

TEST_P(BackgroundTest, TheEndWaitsForAllJobs) {
  int ran = 0;
  {
    Background background(GetParam());
    for (int k = 0; k < 50; ++k) background.submit([&] { ++ran; });
  }
  EXPECT_EQ(ran, 50);
}

TEST_P(BackgroundTest, AJobsCapturesAreReleasedOnceItIsDone) {
  Background background(GetParam());
  auto held = std::make_shared<int>(1);
  background.wait(background.submit([held] {}));
  EXPECT_EQ(held.use_count(), 1);
}

TEST(Background, HasAThreadOfItsOwnOnlyWhereAsked) {
  const auto runner = [](bool own_thread) {
    Background background(own_thread);
    std::thread::id id;
    background.wait(background.submit([&] { id = std::this_thread::get_id(); }));
    return id;
  };
  EXPECT_EQ(runner(false), std::this_thread::get_id());
  EXPECT_NE(runner(true), std::this_thread::get_id());
}

INSTANTIATE_TEST_SUITE_P(Modes, BackgroundTest, testing::Bool(),
                         [](const auto& mode) { return mode.param ? "OwnThread" : "AtOnce"; });

}  // namespace
}  // namespace rastro
