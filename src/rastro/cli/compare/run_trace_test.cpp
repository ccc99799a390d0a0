// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/compare/run_trace.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "rastro/base/append_file.h"
#include "rastro/base/scratch_testing.h"

namespace rastro::cli {
namespace {

constexpr int frames = 40, first_of_run = 15;

/// On a curve, so that no rigid motion takes one part of it to another.
Eigen::Vector2d position(int frame) { return {std::cos(0.002 * frame * frame), 0.1 * frame}; }

/// KITTI has a line for each frame and no stamps.
TEST(RunTrace, PosesWithoutStampsAreComparedOnTheFramesThatBothHave) {
  const std::filesystem::path folder = scratch_folder("common_frames");
  std::string kitti, times, run;
  for (int k = 0; k < frames; ++k) {
    const Eigen::Vector2d at = position(k);
    kitti += fmt::format("1 0 0 {} 0 1 0 0 0 0 1 {}\n", at.x(), at.y());
    times += fmt::format("{}\n", 0.1 * k);
    if (k >= first_of_run) run += fmt::format("{} {} 0 {} 0 0 0 1\n", 0.1 * k, at.x(), at.y());
  }
  std::filesystem::create_directories(folder / "theirs");
  write_whole_file(folder / "poses.txt", kitti);
  write_whole_file(folder / "times.txt", times);
  write_whole_file(folder / "theirs" / "poses.txt", kitti);
  write_whole_file(folder / "run.txt", run);
  TraceReader reader;
  const std::string truth = (folder / "poses.txt").string();
  const auto theirs = reader.read((folder / "theirs" / "poses.txt").string(), truth, "se3", "");
  const auto ours = reader.read((folder / "run.txt").string(), truth, "se3", "");
  ASSERT_TRUE(theirs && ours);
  ASSERT_TRUE(theirs->scores.pairing.by_index);
  const auto common = errors_on_common_frames(*theirs, *ours);
  ASSERT_TRUE(common);
  EXPECT_EQ(common->frames, frames - first_of_run);
  EXPECT_NEAR(common->first_m, 0.0, 1e-6);
  EXPECT_NEAR(common->second_m, 0.0, 1e-6);
}

}  // namespace
}  // namespace rastro::cli
