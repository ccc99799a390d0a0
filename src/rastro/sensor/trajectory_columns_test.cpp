// SPDX-License-Identifier: Apache-2.0
#include "rastro/sensor/trajectory_columns.h"

#include <gtest/gtest.h>

#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

std::string order_of(std::string_view text) {
  const auto columns = named_columns(text);
  if (!columns) return "";
  std::string order;
  for (const std::size_t column : columns->position) order += std::to_string(column) + " ";
  for (const std::size_t column : columns->orientation) order += std::to_string(column) + " ";
  return order;
}

TEST(TrajectoryColumns, AreThoseThatTheHeaderNames) {
  EXPECT_EQ(order_of("# timestamp tx ty tz qx qy qz qw\n1 2 3 4 0 0 0 1\n"), "1 2 3 4 5 6 7 ");
  EXPECT_EQ(order_of("# ground truth\n#time x y z qw qx qy qz\n"), "1 2 3 5 6 7 4 ");
  EXPECT_EQ(order_of("timestamp,qx,qy,qz,qw,tx,ty,tz\n"), "5 6 7 1 2 3 4 ");
  EXPECT_EQ(
      order_of("#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
               "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1]\n"),
      "1 2 3 5 6 7 4 ");
  EXPECT_EQ(order_of("time,.pose.position.x,.pose.position.y,.pose.position.z,.pose.orientation.x,.pose.orientation.y,"
                     ".pose.orientation.z,.pose.orientation.w\n"),
            "1 2 3 4 5 6 7 ");
  EXPECT_EQ(order_of("%time,field.twist.linear.x,field.twist.linear.y,field.twist.linear.z,field.pose.position.x,"
                     "field.pose.position.y,field.pose.position.z,field.pose.orientation.x,field.pose.orientation.y,"
                     "field.pose.orientation.z,field.pose.orientation.w\r\n"),
            "4 5 6 7 8 9 10 ");
}

TEST(TrajectoryColumns, WithoutAllSevenNamesThereIsNoOrder) {
  EXPECT_EQ(order_of("# timestamp tx ty tz qx qy qz\n"), "");
  EXPECT_EQ(order_of("1 2 3 4 0 0 0 1\n# t x y z qw qx qy qz\n"), "") << "after the first pose";
  EXPECT_EQ(order_of(""), "");
  EXPECT_EQ(order_of("#\n,,,,,,,,\n"), "");
}

/// A rotation of 60 degrees about x at (1, 2, 3).
std::string pose_in(const std::string& text) {
  const Trajectory trajectory = parse_tum_trajectory(with_commented_names(text), "test");
  const SE3& pose = trajectory.front().world_from_body;
  const bool right = (pose.translation() - Eigen::Vector3d(1.0, 2.0, 3.0)).norm() < 1e-9 &&
                     (pose.rotation().log() - Eigen::Vector3d(1.0471975512, 0.0, 0.0)).norm() < 1e-6;
  return right ? "right" : "wrong";
}

TEST(TrajectoryColumns, PosesAreReadInThisOrder) {
  EXPECT_EQ(pose_in("0.5 1 2 3 0.5 0 0 0.86602540378"), "right");
  EXPECT_EQ(pose_in("# stamp tx ty tz qw qx qy qz\n0.5 1 2 3 0.86602540378 0.5 0 0"), "right");
  EXPECT_EQ(pose_in("stamp,qw,qx,qy,qz,z,y,x\n0.5,0.86602540378,0.5,0,0,3,2,1"), "right");
  const std::string text = "stamp,x,y,z,qx,qy,qz,qw\n100000000000,1,2,3,0.5,0,0,0.86602540378";
  EXPECT_NEAR(parse_euroc_trajectory(with_commented_names(text), "test").front().world_from_body.rotation().log().x(),
              1.0472, 1e-4);
}

}  // namespace
}  // namespace rastro
