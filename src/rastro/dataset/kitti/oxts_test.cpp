// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/kitti/oxts.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "rastro/dataset/dataset_testing.h"
#include "rastro/dataset/open.h"

namespace rastro {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::string packet_line(double latitude, double longitude, double altitude, double roll, double pitch, double yaw) {
  std::string line =
      fmt::format("{:.12f} {:.12f} {:.6f} {:.9f} {:.9f} {:.9f}", latitude, longitude, altitude, roll, pitch, yaw);
  for (int i = 6; i < 30; ++i) line += " 0";
  return line;
}

TEST(Oxts, a_packet_is_its_first_six_values) {
  const OxtsPacket packet = parse_oxts_packet(packet_line(49.5, 8.25, 116.0, 0.01, -0.02, 3.0) + "\n", "p");
  EXPECT_EQ(packet.latitude_deg, 49.5);
  EXPECT_EQ(packet.longitude_deg, 8.25);
  EXPECT_EQ(packet.altitude_m, 116.0);
  EXPECT_EQ(packet.roll, 0.01);
  EXPECT_EQ(packet.pitch, -0.02);
  EXPECT_EQ(packet.yaw, 3.0);
}

TEST(Oxts, broken_packets_are_errors_of_one_line) {
  const std::string good = packet_line(49.0, 8.4, 0, 0, 0, 0);
  for (const std::string& text :
       {std::string("# nothing"), std::string("1 2 3"), good + " 1", fmt::format("{}\n{}", good, good),
        "nan" + good.substr(12), packet_line(89.9, 8.4, 0, 0, 0, 0), packet_line(49.0, 1e9, 0, 0, 0, 0)}) {
    const std::string message = error_of([&] { parse_oxts_packet(text, "oxts/data/7.txt"); });
    EXPECT_THAT(message, HasSubstr("oxts/data/7.txt")) << text;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

// By hand: at the equator a degree is pi 6378137 / 180 = 111319.4907932264 m along both axes (to first order in the
// latitude); at 60 degrees the scale cos(60) = 1/2 halves the longitude's: 55659.7453966132 m.
TEST(Oxts, mercator_values_by_hand) {
  const std::array<OxtsPacket, 3> equator = {{{0, 0, 5, 0, 0, 0}, {0, 1, 7, 0, 0, 0}, {1e-5, 0, 5, 0, 0, 0}}};
  const auto poses = oxts_poses(equator);
  EXPECT_NEAR(poses[1].translation().x(), 111319.4907932264, 1e-6);
  EXPECT_NEAR(poses[1].translation().y(), 0.0, 1e-6);
  EXPECT_NEAR(poses[1].translation().z(), 2.0, 1e-12);
  EXPECT_NEAR(poses[2].translation().y(), 1.113194907932264, 1e-7);
  const std::array<OxtsPacket, 2> north = {{{60, 10, 0, 0, 0, 0}, {60, 11, 0, 0, 0, 0}}};
  EXPECT_NEAR(oxts_poses(north)[1].translation().x(), 55659.7453966132, 1e-6);
}

TEST(Oxts, poses_are_in_the_frame_of_the_first_one) {
  // Heading north: what lies to the east is to the right of the unit.
  const double north = 0.5 * std::numbers::pi;
  const std::array<OxtsPacket, 2> packets = {{{0, 0, 0, 0, 0, north}, {0, 1e-4, 0, 0.1, 0.2, north}}};
  const auto poses = oxts_poses(packets);
  EXPECT_NEAR(poses[0].log().norm(), 0.0, 1e-12);
  EXPECT_NEAR((poses[1].translation() - Eigen::Vector3d(0, -11.13194907932264, 0)).norm(), 0.0, 1e-6);
  // Rz Ry Rx with yaw 0: its last row is (-sin pitch, cos pitch sin roll, cos pitch cos roll).
  const Eigen::Vector3d last = poses[1].rotation().matrix().row(2);
  EXPECT_NEAR(last.x(), -std::sin(0.2), 1e-12);
  EXPECT_NEAR(last.y(), std::cos(0.2) * std::sin(0.1), 1e-12);
}

constexpr const char* transform = "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.5 -1\n";

TEST(Oxts, is_the_ground_truth_of_a_raw_drive) {
  const ScratchFolder folder;
  write_kitti_raw(folder, 3);
  for (int k = 0; k < 3; ++k)
    folder.write(fmt::format("oxts/data/{:010}.txt", k), packet_line(0, 1e-5 * k, 0, 0, 0, 0) + "\n");
  folder.write("calib_cam_to_cam.txt",
               "S_rect_00: 8 6\nR_rect_00: 1 0 0 0 1 0 0 0 1\nP_rect_00: 6 0 3.5 0 0 6 2.5 0 0 0 1 0\n");
  folder.write("calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -1 0 0\n");
  folder.write("calib_velo_to_cam.txt", transform);
  const auto source = open(folder.path());
  const SourceInfo& info = source->info();
  ASSERT_EQ(info.ground_truth.size(), 3u);
  EXPECT_EQ(info.ground_truth_frame, "body");
  EXPECT_EQ(info.ground_truth[1].stamp - info.ground_truth[0].stamp, 1'000'000'000);
  EXPECT_NEAR(info.ground_truth[2].world_from_body.translation().x(), 2.226389815864528, 1e-7);
  ASSERT_TRUE(info.cameras[0].body_from_camera);
  // camera = R (imu + (-1, 0, 0)) + (0, -0.5, -1): its center is 2 m ahead of the unit and 0.5 m below it.
  const SE3& body_from_camera = *info.cameras[0].body_from_camera;
  EXPECT_NEAR((body_from_camera.translation() - Eigen::Vector3d(2, 0, -0.5)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((body_from_camera.rotation() * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 0, 0)).norm(), 0.0, 1e-9);
}

TEST(Oxts, a_broken_packet_costs_the_ground_truth_only) {
  const ScratchFolder folder;
  write_kitti_raw(folder, 2);
  folder.write("oxts/data/0000000000.txt", packet_line(0, 0, 0, 0, 0, 0));
  folder.write("oxts/data/0000000001.txt", "49 8 x");
  const auto source = open(folder.path());
  EXPECT_TRUE(source->info().ground_truth.empty());
  EXPECT_THAT(source->info().warnings, Contains(testing::AllOf(HasSubstr("0000000001.txt"), HasSubstr("'x'"))));
}

}  // namespace
}  // namespace rastro
