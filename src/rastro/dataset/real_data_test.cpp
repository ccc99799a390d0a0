// SPDX-License-Identifier: Apache-2.0
// Recordings that are not part of the project; skipped, saying so, where they are not there.
#include <gtest/gtest.h>

#include "rastro/base/recorded_data_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

struct Expected {
  const char* folder;
  const char* format;
  std::int64_t frames;
  TimeNs first_stamp;
  int width;
  int height;
  bool calibrated;
  std::size_t ground_truth;
  bool right;
  double depth_factor;
};

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.folder; }

class RealData : public testing::TestWithParam<Expected> {};

TEST_P(RealData, IsReadWhole) {
  const auto& expected = GetParam();
  const auto path = recorded_data(expected.folder);
  if (!path) GTEST_SKIP() << no_recorded_data(expected.folder);

  OpenOptions options;
  options.want_right = options.want_depth = true;
  const auto source = open(path->string(), options);
  const auto& info = source->info();
  EXPECT_EQ(info.format, expected.format);
  EXPECT_EQ(info.frame_count, expected.frames);
  EXPECT_EQ(info.cameras.front().camera.has_value(), expected.calibrated);
  EXPECT_EQ(info.ground_truth.size(), expected.ground_truth);
  EXPECT_EQ(info.has_right, expected.right);
  EXPECT_EQ(info.depth_factor, expected.depth_factor);
  std::int64_t count = 0;
  TimeNs last = -1;
  while (const auto frame = source->next()) {
    if (count == 0) {
      EXPECT_EQ(frame->stamp, expected.first_stamp);
    }
    EXPECT_GT(frame->stamp, last);
    EXPECT_EQ(frame->index, count);
    EXPECT_EQ(frame->image.width(), expected.width);
    EXPECT_EQ(frame->image.height(), expected.height);
    last = frame->stamp;
    ++count;
  }
  EXPECT_EQ(count, expected.frames);
}

INSTANTIATE_TEST_SUITE_P(
    Recordings, RealData,
    testing::Values(
        Expected{"euroc_v1_01_flight", "euroc", 90, 1403715285262142976, 752, 480, true, 170, false, 0.0},
        Expected{"euroc_v1_01_still_stereo", "euroc", 12, 1403715273262142976, 752, 480, true, 32, true, 0.0},
        Expected{"kitti_00", "kitti_odometry", 100, 0, 1241, 376, true, 100, true, 0.0},
        Expected{"kitti_01", "kitti_odometry", 51, 0, 1241, 376, true, 51, false, 0.0},
        Expected{"kitti_residential", "kitti_odometry", 100, 0, 1242, 375, true, 100, false, 0.0},
        Expected{"kitchen_rgbd", "tum_rgbd", 240, 0, 640, 480, false, 240, false, 1000.0},
        Expected{"tum_fr1_rpy_clip", "tum_rgbd", 80, 1305031239529662000, 640, 480, true, 563, false, 5000.0}),
    [](const auto& each) { return std::string(each.param.folder); });

}  // namespace
}  // namespace rastro
