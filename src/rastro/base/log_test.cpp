// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/log.h"

#include <gmock/gmock.h>

#include <thread>
#include <utility>
#include <vector>

namespace rastro {
namespace {

using testing::ElementsAre;
using testing::Pair;

class LogTest : public testing::Test {
 protected:
  void TearDown() override { set_log_sink({}); }
  void record() {
    set_log_sink([this](LogLevel level, const std::string& line) { lines_.emplace_back(level, line); });
  }
  std::vector<std::pair<LogLevel, std::string>> lines_;
};

TEST_F(LogTest, ReachesTheSinkInOrder) {
  record();
  log_info("one");
  log_warning("two");
  log(LogLevel::debug, "three");
  EXPECT_THAT(lines_,
              ElementsAre(Pair(LogLevel::info, "one"), Pair(LogLevel::warning, "two"), Pair(LogLevel::debug, "three")));
}

TEST_F(LogTest, IsDroppedWithoutASink) {
  record();
  set_log_sink({});
  log_info("nobody hears this");
  EXPECT_TRUE(lines_.empty());
}

TEST_F(LogTest, LosesNothingBetweenThreads) {
  record();
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([] {
      for (int k = 0; k < 500; ++k) log_info("line");
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(lines_.size(), 2000U);
}

}  // namespace
}  // namespace rastro
