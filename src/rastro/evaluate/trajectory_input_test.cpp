// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_input.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"

namespace rastro {
namespace {

using testing::HasSubstr;

constexpr const char* two_kitti_poses = "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2\n";

class TrajectoryInputFiles : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    write_whole_file(folder_ / name, text);
    return (folder_ / name).string();
  }
  std::filesystem::path folder_ = scratch_folder("trajectory_input");
};

template <typename Run>
std::string error_of(Run run) {
  try {
    run();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST_F(TrajectoryInputFiles, UnitsOfStampsAreDetected) {
  const std::string pose = " 1 2 3 0 0 0 1\n";
  for (const auto& [first, second, from] :
       {std::tuple("1305031102.1", "1305031102.2", "in s"), std::tuple("1305031102100", "1305031102200", "in ms"),
        std::tuple("1305031102100000000", "1305031102200000000", "in ns")}) {
    const auto input = read_trajectory_input(write("t.txt", fmt::format("{}{}{}{}", first, pose, second, pose)));
    EXPECT_EQ(input.stamps_from, from);
    ASSERT_EQ(input.poses.size(), 2u);
    EXPECT_EQ(input.poses[0].stamp, 1305031102100000000);
    EXPECT_EQ(input.poses[1].stamp, 1305031102200000000);
  }
  const auto euroc = read_trajectory_input(
      write("e.csv", "#t,x,y,z,w,x,y,z\n1305031102100,1,2,3,1,0,0,0\n1305031102200,1,2,3,1,0,0,0\n"));
  EXPECT_EQ(euroc.stamps_from, "in ms");
  EXPECT_EQ(euroc.poses[0].stamp, 1305031102100000000);
}

TEST_F(TrajectoryInputFiles, KittiPosesTakeStampsFromTheFileBeside) {
  const std::string file = write("00.txt", two_kitti_poses);
  const auto bare = read_trajectory_input(file);
  EXPECT_FALSE(bare.has_stamps);
  EXPECT_THAT(describe(bare), HasSubstr("(KITTI, 2 poses, no stamps)"));
  write("times.txt", "0\n0.1\n");
  EXPECT_EQ(read_trajectory_input(file).poses[1].stamp, 100'000'000);
  write("00_times.txt", "5\n5.2\n");
  EXPECT_EQ(read_trajectory_input(file).poses[1].stamp, 5'200'000'000);
  write("00_times.txt", "5\n");  // too short to be of these poses
  EXPECT_EQ(read_trajectory_input(file).poses[1].stamp, 100'000'000);
}

TEST_F(TrajectoryInputFiles, GivenTimesMustMatch) {
  const std::string file = write("00.txt", two_kitti_poses);
  EXPECT_EQ(read_trajectory_input(file, write("a", "7\n8\n9\n")).poses[1].stamp, 8'000'000'000);
  EXPECT_THAT(error_of([&] { read_trajectory_input(file, write("b", "7\n")); }), HasSubstr("1 stamps for 2 poses"));
  EXPECT_THAT(error_of([&] { read_trajectory_input(file, write("c", "7\n7\n")); }), HasSubstr("do not increase"));
}

TEST_F(TrajectoryInputFiles, KittiMatricesStayAsTheyAreWritten) {
  const auto input = read_trajectory_input(write("k.txt", "0.9999 0 0 1 0 1 0 2 0 0 1.0001 3\n"));
  EXPECT_EQ(input.matrices[0](0, 0), 0.9999);
  EXPECT_EQ(input.matrices[0](2, 2), 1.0001);
  EXPECT_NEAR(input.poses[0].world_from_body.matrix()(0, 0), 1.0, 1e-12);
}

TEST_F(TrajectoryInputFiles, InputThatCannotBeScoredIsAnError) {
  EXPECT_THAT(error_of([&] { read_trajectory_input(write("far", "0 1e200 0 0 0 0 0 1\n")); }), HasSubstr("m away"));
  EXPECT_THAT(error_of([&] { read_trajectory_input(write("odd", "1 2 3\n")); }), HasSubstr("no trajectory format"));
  EXPECT_THAT(error_of([&] { read_trajectory_input((folder_ / "none").string()); }), HasSubstr("none"));
}

}  // namespace
}  // namespace rastro
