// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "rastro/dataset/dataset_testing.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Check, AWholeRecordingIsUsable) {
  const ScratchFolder folder;
  write_tum(folder, 6);
  std::int64_t last = 0;
  const auto report = check(folder.path(), {}, [&](std::int64_t done, std::int64_t) { last = done; });
  EXPECT_EQ(last, 6);
  EXPECT_TRUE(report.usable);
  EXPECT_EQ(report.frames_read, 6);
  EXPECT_EQ(report.depth.frames_with_depth, 6);
  EXPECT_NEAR(report.stamps.rate_hz, 20.0, 1e-9);
  EXPECT_EQ(report.ground_truth_percent, 100.0);
  EXPECT_EQ(report.stamps.stamp_unit, "s");
  EXPECT_THAT(report.depth.depth_offset_histogram, ElementsAre(0, 0, 0, 0, 6, 0, 0, 0));
  EXPECT_NEAR(report.depth.depth_offset_max_ms, 4.0, 1e-9);
  EXPECT_THAT(to_text(report), HasSubstr("verdict       usable, see the warnings"));
}

TEST(Check, FindsEverythingThatIsBrokenAndGoesOn) {
  const ScratchFolder folder;
  write_tum(folder, 8);
  // Frame 2 repeats, 3 goes back, a gap follows 5.
  folder.write("rgb.txt",
               "1000.00 rgb/0.png\n1000.05 rgb/1.png\n1000.05 rgb/2.png\n1000.04 rgb/3.png\n1000.10 rgb/4.png\n"
               "1000.15 rgb/5.png\n1000.40 rgb/6.png\n1000.45 rgb/7.png\n");
  folder.truncate("rgb/1.png", 0.5);
  folder.write("depth/2.png", "");  // The one nearest to frame 4.
  const auto report = check(folder.path(), {});
  EXPECT_TRUE(report.usable);
  EXPECT_EQ(report.frames_read, 7);
  EXPECT_THAT(report.stamps.repeated_stamps, ElementsAre(2));
  EXPECT_THAT(report.stamps.backward_stamps, ElementsAre(3));
  ASSERT_EQ(report.stamps.gaps.size(), 1u);
  EXPECT_EQ(report.stamps.gaps[0].after_frame, 5);
  EXPECT_NEAR(report.stamps.gaps[0].seconds, 0.25, 1e-9);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("no calibration found")));
  EXPECT_THAT(to_text(report), HasSubstr("frame 1: "));
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json["usable"], true);
  EXPECT_EQ(json["frames_read"], 7);
  EXPECT_EQ(json["unreadable_images"].size(), report.unreadable_images.size());
  EXPECT_GE(report.unreadable_images.size(), 2u);
}

TEST(Check, ChangingSizeAndUnreadableRecordingsAreUnusable) {
  const ScratchFolder folder;
  write_euroc(folder, 4);
  folder.write_gray("mav0/cam0/data/1400000000100000000.png", 1, 10, 6);
  auto report = check(folder.path(), {});
  EXPECT_FALSE(report.usable);
  ASSERT_EQ(report.size_changes.size(), 1u);
  EXPECT_EQ(report.size_changes[0].frame, 2);
  EXPECT_THAT(report.reasons, Contains(HasSubstr("the images change their size")));

  for (int k = 0; k < 4; ++k)
    folder.write(
        std::string("mav0/cam0/data/1400000000") + (k < 2 ? (k ? "05" : "00") : (k == 2 ? "10" : "15")) + "0000000.png",
        "x");
  report = check(folder.path(), {});
  EXPECT_FALSE(report.usable);
  EXPECT_EQ(report.frames_read, 0);
  EXPECT_EQ(report.unreadable_images.size(), 4u);
  EXPECT_THAT(report.reasons, Contains("no frame can be read"));
  EXPECT_THAT(to_text(report), HasSubstr("cannot be used"));
}

TEST(Check, DarkImagesAreNamed) {
  const ScratchFolder folder;
  for (int k = 0; k < 4; ++k) folder.write_gray("night/" + std::to_string(k) + ".png", 3);
  const CheckReport report = check(folder.path("night"), {});
  EXPECT_EQ(report.blank_images, (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_THAT(report.warnings, Contains(HasSubstr("4 of 4 images are dark or blank")));
}

}  // namespace
}  // namespace rastro
