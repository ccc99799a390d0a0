// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/watched_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "rastro/base/scratch_testing.h"
#include "rastro/base/text_file.h"

namespace rastro {
namespace {

using ::testing::HasSubstr;

/// The same scan in every frame, while the wheels move 0.2 m a frame.
Frame stuck_frame(std::int64_t index) {
  Frame frame;
  frame.index = index;
  LaserScan& scan = frame.scan.emplace();
  scan.first_angle = -1.0, scan.angle_step = 0.02, scan.max_range = 10.0;
  frame.scan->ranges.assign(100, 3.0F);
  frame.odometry_from_body = SE2(SO2(), {0.2 * static_cast<double>(index), 0.0});
  return frame;
}

TEST(WatchedInput, TellsOnceInEventsAndAsJson) {
  const auto path = scratch_path("watched");
  RunFolder folder(path, false);
  WatchedInput input({}, &folder);
  for (std::int64_t k = 0; k < 20; ++k) input.add(stuck_frame(k));
  ASSERT_EQ(input.warnings().size(), 1U);
  const auto json = json_of(input.warnings());
  EXPECT_EQ(json[0]["kind"], "laser_stuck");
  EXPECT_EQ(json[0]["text"], input.warnings().front().text);
  const std::string events = read_text_file((path / "events.jsonl").string());
  EXPECT_THAT(events, HasSubstr(R"("frame":5,"event":"input_warning","text":"laser_stuck: )"));
  EXPECT_TRUE(json_of(InputWarnings{}).is_array());
}

}  // namespace
}  // namespace rastro
