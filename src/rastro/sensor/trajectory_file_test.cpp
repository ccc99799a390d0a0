// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/trajectory_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "rastro/base/error.h"

namespace rastro {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

template <typename Read>
std::string error_of(Read read) {
  try {
    read();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(PoseAt, IsOnTheGeodesicBetweenNeighbors) {
  const SE3 begin, end(SO3::exp({0, 0, 1.0}), {2, 4, 6});
  const Trajectory trajectory = {{100, begin}, {200, end}};
  const auto middle = pose_at(trajectory, 150, 100);
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->rotation().log().z(), 0.5, 1e-12);
  EXPECT_TRUE(pose_at(trajectory, 100, 0));
  EXPECT_TRUE(pose_at(trajectory, 200, 0));
  EXPECT_FALSE(pose_at(trajectory, 99, 1000));
  EXPECT_FALSE(pose_at(trajectory, 201, 1000));
  EXPECT_FALSE(pose_at(trajectory, 150, 99));
  EXPECT_FALSE(pose_at({}, 0, 1000));
}

TEST(TrajectoryFile, FormatsAgreeOnOnePose) {
  const double half = std::sqrt(0.5);  // 90 degrees about z
  const auto tum = parse_tum_trajectory("# c\n0.5 1 2 3 0 0 " + std::to_string(half) + " " + std::to_string(half), "t");
  const auto euroc =
      parse_euroc_trajectory("500000000,1,2,3," + std::to_string(half) + ",0,0," + std::to_string(half) + ",9,9", "e");
  const auto kitti = parse_kitti_poses("0 -1 0 1 1 0 0 2 0 0 1 3\n", "k");
  ASSERT_EQ(tum.size(), 1u);
  ASSERT_EQ(euroc.size(), 1u);
  EXPECT_EQ(tum[0].stamp, 500000000);
  EXPECT_EQ(euroc[0].stamp, 500000000);
  EXPECT_TRUE(tum[0].world_from_body.matrix().isApprox(kitti[0].matrix(), 1e-6));
  EXPECT_TRUE(euroc[0].world_from_body.matrix().isApprox(kitti[0].matrix(), 1e-6));
}

TEST(TrajectoryFile, SortsByStampAndKeepsTheFirstOfEqualOnes) {
  const auto trajectory = parse_tum_trajectory("2 2 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 9 0 0 0 0 0 1\n", "t");
  ASSERT_EQ(trajectory.size(), 2u);
  EXPECT_EQ(trajectory[0].world_from_body.translation().x(), 1.0);
  EXPECT_EQ(trajectory[1].world_from_body.translation().x(), 2.0);
}

TEST(TrajectoryFile, ErrorsNameFileAndLine) {
  const auto tum = [](const char* text) { return error_of([&] { parse_tum_trajectory(text, "gt.txt"); }); };
  EXPECT_THAT(tum("# c\n\n1 2 3\n"), AllOf(StartsWith("gt.txt:3:"), HasSubstr("3 columns instead of the 8")));
  EXPECT_THAT(tum("1 0 0 nan 0 0 0 1"),
              AllOf(StartsWith("gt.txt:1:"), HasSubstr("column 4 is 'nan', not a finite number")));
  EXPECT_THAT(tum("x 0 0 0 0 0 0 1"), HasSubstr("the stamp 'x' is not a number of s"));
  EXPECT_THAT(tum("1 0 0 0 0 0 0 0"), HasSubstr("the quaternion has length 0 instead of 1"));
  EXPECT_THAT(tum("1 0 0 0 0 0 0 1.2"), HasSubstr("length 1.2"));
  EXPECT_THAT(tum("# only a comment\n"), HasSubstr("gt.txt: has no poses"));
  EXPECT_EQ(tum("1 0 0 0 0 0 0 1.05"), "");

  const auto kitti = [](const char* text) { return error_of([&] { parse_kitti_poses(text, "00.txt"); }); };
  EXPECT_THAT(kitti("1 0 0 0 0 1 0 0 0 0 1\n"), AllOf(StartsWith("00.txt:1:"), HasSubstr("11 columns")));
  EXPECT_THAT(kitti("2 0 0 0 0 1 0 0 0 0 1 0\n"), HasSubstr("not a rotation (error 3)"));
  EXPECT_THAT(kitti("-1 0 0 0 0 1 0 0 0 0 1 0\n"), HasSubstr("not a rotation"));
  EXPECT_THAT(error_of([] { parse_euroc_trajectory("1,2,3\n", "d.csv"); }),
              HasSubstr("d.csv:1: 3 columns instead of at least"));
  EXPECT_THAT(error_of([] { parse_kitti_times("0.1\nabc\n", "times.txt"); }),
              StartsWith("times.txt:2: the stamp 'abc'"));
  EXPECT_THAT(error_of([] { guess_trajectory_format("1 2 3", "f"); }),
              HasSubstr("3 columns match no trajectory format"));
}

TEST(TrajectoryFile, DetectsTheFormat) {
  EXPECT_EQ(guess_trajectory_format("# c\n1 0 0 0 0 0 0 1\n", "f"), TrajectoryFormat::tum);
  EXPECT_EQ(guess_trajectory_format("1 0 0 0 0 1 0 0 0 0 1 0\n", "f"), TrajectoryFormat::kitti);
  EXPECT_EQ(guess_trajectory_format("1,0,0,0,1,0,0,0\n", "f"), TrajectoryFormat::euroc);
  EXPECT_EQ(guess_trajectory_format("1.5,0,0,0,0,0,0,1\n", "f"), TrajectoryFormat::tum);
}

}  // namespace
}  // namespace rastro
