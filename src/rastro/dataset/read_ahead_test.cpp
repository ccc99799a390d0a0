// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <string>

#include "rastro/base/error.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

/// Counts what has been made; every seventh frame is an Error. `alive` is true as long as it lives.
class CountingSource final : public Source {
 public:
  CountingSource(std::int64_t count, std::atomic<std::int64_t>& made, std::atomic<bool>* alive = nullptr)
      : count_(count), made_(made), alive_(alive) {
    if (alive_) *alive_ = true;
  }
  ~CountingSource() override {
    if (alive_) *alive_ = false;
  }
  const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    if (position_ == count_) return std::nullopt;
    Frame frame;
    frame.index = position_++;
    ++made_;
    if (frame.index % 7 == 6) throw Error(fmt::format("frame {}", frame.index));
    return frame;
  }

 private:
  SourceInfo info_;
  std::int64_t count_;
  std::int64_t position_ = 0;
  std::atomic<std::int64_t>& made_;
  std::atomic<bool>* alive_;
};

TEST(ReadAhead, KeepsOrderAndErrorsAndNeverHoldsMoreThanItsDepth) {
  for (const int depth : {1, 3, 8}) {
    std::atomic<std::int64_t> made{0};
    const auto source = read_ahead(std::make_unique<CountingSource>(300, made), depth);
    for (std::int64_t k = 0; k < 300; ++k) {
      EXPECT_LE(made.load(), k + depth);
      if (k % 7 == 6) {
        EXPECT_EQ(error_of([&] { source->next(); }), fmt::format("frame {}", k));
      } else {
        EXPECT_EQ(source->next()->index, k);
      }
    }
    EXPECT_FALSE(source->next());
    EXPECT_FALSE(source->next());
  }
}

/// The next frame's index, or what it says where it is an Error; -1 at the end.
std::string outcome_of(Source& source) {
  std::int64_t index = -1;
  const std::string error = error_of([&] {
    if (const auto frame = source.next()) index = frame->index;
  });
  return error.empty() ? std::to_string(index) : error;
}

TEST(ReadAhead, LeftAtAnyPointItStopsReadingAndLetsTheSourceGo) {
  constexpr int depth = 2;
  for (const std::int64_t length : {6, 100'000}) {  // over while it is read, and far from over
    for (int taken = 0; taken < 20; ++taken) {
      std::atomic<std::int64_t> made{0};
      std::atomic<bool> alive{false};
      {
        const auto source = read_ahead(std::make_unique<CountingSource>(length, made, &alive), depth);
        for (int k = 0; k < taken; ++k) {
          const std::string expected =
              k >= length ? "-1" : (k % 7 == 6 ? "frame " + std::to_string(k) : std::to_string(k));
          EXPECT_EQ(outcome_of(*source), expected);
        }
        EXPECT_TRUE(alive);
      }
      EXPECT_FALSE(alive) << "whoever is left holds the recording open";
      EXPECT_LE(made, std::min<std::int64_t>(length, taken + depth)) << "it read on after it was left";
      EXPECT_GE(made, std::min<std::int64_t>(length, taken));
    }
  }
}

TEST(ReadAhead, DepthZeroIsTheSourceItself) {
  std::atomic<std::int64_t> made{0};
  auto inner = std::make_unique<CountingSource>(3, made);
  const Source* address = inner.get();
  EXPECT_EQ(read_ahead(std::move(inner), 0).get(), address);
}

}  // namespace
}  // namespace rastro
