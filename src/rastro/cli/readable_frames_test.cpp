// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/readable_frames.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"

namespace rastro::cli {
namespace {

/// Frames 0 to 4, of which the second cannot be read; after them nothing, or an end that no frame follows.
class BrokenSource : public Source {
 public:
  explicit BrokenSource(bool unusable) : unusable_(unusable) {}
  const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    const std::int64_t index = next_++;
    if (index == 1) throw Error("is broken", "frame 1", "");
    if (index == 5 && unusable_) throw UnusableSource("changes its size", "frame 5", "");
    if (index >= 5) return std::nullopt;
    Frame frame;
    frame.index = index;
    return frame;
  }

 private:
  SourceInfo info_;
  bool unusable_;
  std::int64_t next_ = 0;
};

TEST(ReadableFrames, OneThatCannotBeReadIsSkipped) {
  BrokenSource source(false);
  std::vector<std::int64_t> indices;
  while (const auto frame = next_readable(source)) indices.push_back(frame->index);
  EXPECT_EQ(indices, (std::vector<std::int64_t>{0, 2, 3, 4}));
}

TEST(ReadableFrames, ASourceThatCannotBeUsedIsAnError) {
  BrokenSource source(true);
  for (int frames = 0; frames < 4; ++frames) EXPECT_TRUE(next_readable(source));
  EXPECT_THROW(next_readable(source), UnusableSource);
}

}  // namespace
}  // namespace rastro::cli
