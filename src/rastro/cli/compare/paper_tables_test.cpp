// SPDX-License-Identifier: Apache-2.0
// Behavior, Table I and figures 9 to 14 beside ours; lengths have a test of their own.
#include "rastro/cli/compare/paper_tables.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "rastro/base/append_file.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/compare/paper_behavior.h"
#include "rastro/cli/compare/paper_front_end.h"
#include "rastro/cli/compare/paper_positioning.h"

namespace rastro::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double turn = std::numbers::pi / 180.0;

/// A camera (x right, y down, z forward) that looks along y of the world, drives `forward` that way and turns left.
StampedPose camera_pose(int second, double forward, double left_deg) {
  const Eigen::Matrix3d start = (Eigen::Matrix3d() << 1, 0, 0, 0, 0, 1, 0, -1, 0).finished();
  const Eigen::Matrix3d left = Eigen::AngleAxisd(left_deg * turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return {second * ns_per_second, SE3(SO3::from_matrix(left * start), Eigen::Vector3d(5.0, forward, 1.0))};
}

TEST(VehicleMotion, IsForwardLeftAndUpFromTheFirstPose) {
  const StampedPose start = camera_pose(3, 2.0, 0.0);
  const VehicleMotion motion = vehicle_motion({start, camera_pose(4, 4.5, 30.0)}, true, start);
  EXPECT_THAT(motion.times_s, ElementsAre(0.0, 1.0));
  EXPECT_TRUE(motion.positions_m[1].isApprox(Eigen::Vector3d(2.5, 0.0, 0.0), 1e-9))
      << motion.positions_m[1].transpose();
  EXPECT_TRUE(motion.angles_deg[1].isApprox(Eigen::Vector3d(0.0, 0.0, 30.0), 1e-6)) << motion.angles_deg[1].transpose();
}

TEST(VehicleMotion, CountsTurnsOn) {
  Trajectory poses;
  for (int k = 0; k <= 5; ++k) poses.push_back(camera_pose(k, 0.0, -80.0 * k));
  EXPECT_NEAR(vehicle_motion(poses, true, poses.front()).angles_deg.back().z(), -400.0, 1e-6);
}

/// 60 frames of a drive; the estimate begins with frame `first`, is up to 3 m to the left and turns.
ColumnTrace drifting(const std::string& column, int first = 0) {
  ColumnTrace each;
  each.column = column;
  auto reference = std::make_shared<ReferenceTrajectory>();
  for (int k = 0; k < 60; ++k) {
    reference->input.poses.push_back(camera_pose(k, k, 0.0));
    if (k < first) continue;
    StampedPose is = camera_pose(k, k, 0.1 * k);
    is.world_from_body = SE3(is.world_from_body.rotation(), Eigen::Vector3d(5.0 - 3.0 * k / 59.0, k, 1.0));
    each.trace.scores.aligned.push_back(is);
    each.trace.scores.pairs.push_back({static_cast<std::size_t>(k), static_cast<std::size_t>(k)});
  }
  each.trace.scores.ate_m.emplace();
  each.trace.reference = reference;
  return each;
}

TEST(PaperTables, HaveTheFiguresOfADriveBesideThePapers) {
  Comparison comparison;
  comparison.inputs.resize(1);
  comparison.inputs[0].name = "street";
  for (const char* column : {"classic", "orb mono"}) comparison.table.add_column(column);
  const auto tables = paper_positioning_tables(comparison, {drifting("classic"), drifting("orb mono")});
  ASSERT_EQ(tables.size(), 1U);
  ASSERT_EQ(tables[0].rows.size(), 2U) << "the head, and classic: the paper has no orb";
  EXPECT_THAT(tables[0].rows[1], ElementsAre("classic", "0.00", "20", "3.00", "80", "0.00", "5", "5.00", "-", "5.90"));
  ASSERT_EQ(tables[0].charts.size(), 14U);
  EXPECT_THAT(tables[0].charts[1].title, HasSubstr("accumulated yaw"));
  EXPECT_NEAR(tables[0].charts[1].lines.back().y.back(), 5.9, 1e-6);
}

TEST(PaperTables, HaveOneClockAndOneStartForMethodsThatBeginLater) {
  Comparison comparison;
  comparison.inputs.resize(1);
  for (const char* column : {"classic", "profiles"}) comparison.table.add_column(column);
  const auto tables = paper_positioning_tables(comparison, {drifting("classic", 20), drifting("profiles")});
  ASSERT_EQ(tables.size(), 1U);
  EXPECT_EQ(tables[0].rows[1][7], "3.00")
      << "frame 50 of the recording, not of the method: 0.1 degrees a frame since 20";
  EXPECT_EQ(tables[0].rows[2][7], "5.00");
  const Chart& forward = tables[0].charts[2];
  ASSERT_EQ(forward.lines.size(), 3U);
  EXPECT_TRUE(forward.lines[0].is_reference);
  EXPECT_EQ(forward.lines[0].x.size(), 60U) << "the ground truth of the longest of them";
  EXPECT_NEAR(forward.lines[1].x.front(), 20.0, 1e-9);
  EXPECT_NEAR(forward.lines[1].y.front(), 20.0, 1e-9) << "meters since the start, not since its first pose";
  EXPECT_NEAR(forward.lines[2].x.front(), 0.0, 1e-9);
}

TEST(PaperTables, HaveBehaviorInARoom) {
  Comparison comparison;
  comparison.inputs.resize(1);
  comparison.inputs[0].name = "study";
  comparison.inputs[0].facts.has_depth = true;
  comparison.table.add("study", "lsd rgbd", "frames_per_second", {61.0, 1, 1, ""});
  StrengthCurve curve{0, "lsd rgbd", "abrupt", {}};
  curve.steps.resize(2);
  curve.steps[0].strength = 2.0, curve.steps[1].strength = 4.0;
  curve.steps[1].recovery_s = 0.1;
  comparison.strengths = {curve};
  const auto tables = paper_behavior_tables(comparison);
  ASSERT_EQ(tables.size(), 1U);
  EXPECT_THAT(tables[0].rows[1], ElementsAre("lsd rgbd", "61.0", HasSubstr("slow"), "-", "4 frames: 0.10 s", "-",
                                             HasSubstr("mostly not back")));
}

TEST(PaperTables, HaveTableOneOfWhatWasTracked) {
  Comparison comparison;
  comparison.inputs.resize(1);
  FrontEndFigures figures;
  figures.tracker = "paper";
  TrackFrame frame;
  frame.tracked = 140, frame.lost = 10, frame.reidentified = 3, frame.fresh = 7;
  frame.times.total_ms = 1.5;
  figures.means.add(frame);
  comparison.front_end = {figures};
  const auto tables = paper_front_end_tables(comparison);
  ASSERT_EQ(tables.size(), 1U);
  EXPECT_THAT(tables[0].rows[1], ElementsAre("paper", "140.0", "3.0", "30.00", "1.50", ""));
  EXPECT_EQ(tables[0].rows[2][1], "125.5");
}

/// The second of three images is black.
std::string images_with_a_loss() {
  constexpr int width = 320, height = 240, block = 16;
  const auto folder = scratch_folder("images");
  for (int frame = 0; frame < 3; ++frame) {
    std::string image = fmt::format("P5\n{} {}\n255\n", width, height);
    for (int k = 0; k < width * height; ++k) {
      const int column = k % width / block, row = k / width / block;
      image += static_cast<char>(frame == 1 ? 0 : 30 + 37 * (column * column + 3 * row * row + column * row) % 200);
    }
    write_whole_file(folder / fmt::format("{}.pgm", frame), image);
  }
  return folder.string();
}

TEST(PaperTables, TrackTheChosenFramesOnly) {
  const std::string recording = images_with_a_loss();
  std::vector<CompareInput> inputs(1);
  inputs[0].facts.has_image = true;
  const auto all = front_end_figures(inputs, {recording});
  ASSERT_EQ(all.size(), 3U);
  EXPECT_GT(all[0].means.frames(), 0);
  inputs[0].input.frames = "0:1";
  const auto first = front_end_figures(inputs, {recording});
  ASSERT_EQ(first.size(), 3U);
  EXPECT_EQ(first[0].means.frames(), 0) << "nothing is lost in one frame";
  EXPECT_THAT(first[1].command, HasSubstr("--preset paper --frames 0:1 --out DIR"));
}

TEST(PaperTables, TrackWhatHasNoDepth) {
  InputFacts room, drive;
  room.has_depth = true;
  EXPECT_THAT(paper_methods(room), testing::Contains("lsd:rgbd"));
  EXPECT_THAT(paper_methods(drive), testing::Contains("odometry/classic"));
}

}  // namespace
}  // namespace rastro::cli
