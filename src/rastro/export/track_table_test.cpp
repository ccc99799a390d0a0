// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/track_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/scratch_testing.h"
#include "rastro/export/track_frames_testing.h"

namespace rastro {
namespace {

TrackFrame row(std::int64_t index, int tracked, int reidentified, int fresh, int lost, double ms) {
  TrackFrame frame;
  frame.index = index;
  frame.tracked = tracked;
  frame.reidentified = reidentified;
  frame.fresh = fresh;
  frame.lost = lost;
  frame.times.total_ms = ms;
  return frame;
}

std::string table_of(const std::vector<TrackFrame>& frames) {
  const auto path = scratch_folder("table") / "table.md";
  TrackTableFile table(path);
  for (const TrackFrame& frame : frames) table.write(frame, {});
  table.finish();
  return read_whole_file(path);
}

TEST(TrackTable, MeanIsOverTheRowsInWhichSomethingWasLost) {
  const std::string text = table_of({row(0, 0, 0, 150, 0, 100.0), row(1, 140, 6, 4, 10, 20.0),
                                     row(2, 150, 0, 0, 0, 50.0), row(3, 120, 3, 27, 30, 30.0)});
  EXPECT_THAT(text, testing::HasSubstr("| 0 | 0 | 0 | 0.00 | 100.00 |\n"));
  EXPECT_THAT(text, testing::HasSubstr("| 1 | 140 | 6 | 60.00 | 20.00 |\n"));
  EXPECT_THAT(text, testing::HasSubstr("| 2 | 150 | 0 | - | 50.00 |\n")) << "no corner, no percentage";
  EXPECT_THAT(text, testing::HasSubstr("| 3 | 120 | 3 | 10.00 | 30.00 |\n"));
  EXPECT_THAT(text, testing::HasSubstr("| **mean** | 130.0 | 4.5 | 35.00 | 25.00 |\n"));
}

TEST(TrackTable, RowsWithoutCornersAreLeftOutOfTheMeanPercentage) {
  const std::string text = table_of({row(1, 140, 5, 5, 10, 20.0), row(2, 100, 0, 0, 40, 40.0)});
  EXPECT_THAT(text, testing::HasSubstr("| **mean** | 120.0 | 2.5 | 50.00 | 30.00 |\n"));
}

TEST(TrackTable, HasOnlyTheFramesAskedFor) {
  const auto path = scratch_folder("table") / "table.md";
  TrackTableFile table(path, std::pair<std::int64_t, std::int64_t>(1, 3));
  for (int k = 0; k < 4; ++k) table.write(row(k, 100 + k, 2, 2, 10, 20.0), {});
  table.finish();
  const std::string text = read_whole_file(path);
  EXPECT_THAT(text, testing::HasSubstr("| 1 | 101 |"));
  EXPECT_THAT(text, testing::HasSubstr("| 2 | 102 |"));
  EXPECT_THAT(text, testing::Not(testing::AnyOf(testing::HasSubstr("| 0 | 100"), testing::HasSubstr("| 3 | 103"))));
  EXPECT_THAT(text, testing::HasSubstr("| **mean** | 101.5 |"));
}

TEST(TrackTable, SaysWhenNothingWasLost) {
  EXPECT_THAT(table_of({row(0, 0, 0, 150, 0, 1.0)}), testing::HasSubstr("there is no mean"));
}

}  // namespace
}  // namespace rastro
