// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>

#include "rastro/base/error.h"
#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

/// Counts what has been made; every seventh frame is an Error.
class CountingSource final : public Source {
 public:
  CountingSource(std::int64_t count, std::atomic<std::int64_t>& made) : count_(count), made_(made) {}
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

TEST(ReadAhead, MayBeLeftAtAnyPoint) {
  for (int taken = 0; taken < 20; ++taken) {
    std::atomic<std::int64_t> made{0};
    const auto source = read_ahead(std::make_unique<CountingSource>(6, made), 2);
    for (int k = 0; k < taken; ++k) error_of([&] { source->next(); });
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
