// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/write_laser_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/sensor/trajectory_file.h"
#include "rastro/synthetic/worlds/corridor.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

const LaserWorld& office() {
  static const LaserWorld world = make_corridor_floor();
  return world;
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    files[entry.path().filename().string()] = read_text_file(entry.path().string());
  return files;
}

TEST(WriteLaserLog, gives_the_same_bytes_for_any_threads_and_different_ones_for_another_seed) {
  TaskPool one(1), three(3);
  const fs::path a = scratch_path("a"), b = scratch_path("b"), c = scratch_path("c");
  const LaserLogSummary summary = write_laser_log(office(), a, {.scans = 70}, one);
  write_laser_log(make_corridor_floor(), b, {.scans = 70}, three);
  write_laser_log(make_corridor_floor({.seed = 2}), c, {.scans = 70}, three);
  const auto first = files_of(a), second = files_of(b), other = files_of(c);
  EXPECT_EQ(first.size(), 8U);
  EXPECT_EQ(first, second);
  EXPECT_NE(first.at("scans.log"), other.at("scans.log"));
  EXPECT_EQ(first.at("groundtruth.txt"), other.at("groundtruth.txt")) << "the trajectory stays the same";
  EXPECT_EQ(summary.scans, 70);
  EXPECT_LE(summary.bytes, first.at("scans.log").size());
  EXPECT_THROW(write_laser_log(office(), a, {.scans = 70}, one), Error) << "the folder is not empty";
  EXPECT_THROW(write_laser_log(office(), scratch_path("none"), {.scans = 0}, one), Error);
}

/// What the former drive left would be taken for a part of the new one.
TEST(WriteLaserLog, an_interrupted_one_keeps_nothing_of_the_drive_that_it_replaces) {
  struct Stopped {};
  TaskPool pool(2);
  const fs::path folder = scratch_path("replaced");
  write_laser_log(office(), folder, {.scans = 70}, pool);
  const auto stop = [](std::int64_t) { throw Stopped{}; };
  EXPECT_THROW(write_laser_log(office(), folder, {.scans = 70, .force = true}, pool, stop), Stopped);
  for (const char* name : {"relations.txt", "landmarks_truth.csv", "floor_plan.pgm", "floor_plan.yaml"})
    EXPECT_FALSE(fs::exists(folder / name)) << name;
  EXPECT_TRUE(fs::exists(folder / "scans.log"));
}

TEST(WriteLaserLog, ground_truth_and_relations_are_those_of_the_drive) {
  TaskPool pool(2);
  const fs::path folder = scratch_path("truth");
  write_laser_log(office(), folder, {.scans = 90}, pool);
  const Trajectory ground_truth =
      parse_tum_trajectory(read_text_file((folder / "groundtruth.txt").string()), "groundtruth.txt");
  ASSERT_EQ(ground_truth.size(), 90U);
  std::map<TimeNs, SE3> pose_of;
  for (std::size_t i = 0; i < ground_truth.size(); ++i) {
    const auto scan = static_cast<std::int64_t>(i);
    EXPECT_EQ(ground_truth[i].stamp, office().stamp(scan));
    const SE2 should = office().world_from_body(office().time_of(scan));
    EXPECT_LT((ground_truth[i].world_from_body.translation().head<2>() - should.translation()).norm(), 1e-8);
    EXPECT_NEAR(ground_truth[i].world_from_body.rotation().log().z(), should.rotation().angle(), 1e-9);
    pose_of[ground_truth[i].stamp] = ground_truth[i].world_from_body;
  }
  const std::string relations = read_text_file((folder / "relations.txt").string());
  int lines = 0;
  for (const auto line : split(relations, '\n')) {
    if (line.empty()) continue;
    const auto words = split_words(line);
    ASSERT_EQ(words.size(), 8U);
    const SE3& first = pose_of.at(*parse_stamp(words[0], StampUnit::seconds));
    const SE3& second = pose_of.at(*parse_stamp(words[1], StampUnit::seconds));
    const SE3 motion = first.inverse() * second;
    EXPECT_NEAR(*parse_double(words[2]), motion.translation().x(), 1e-6);
    EXPECT_NEAR(*parse_double(words[3]), motion.translation().y(), 1e-6);
    EXPECT_NEAR(*parse_double(words[7]), motion.rotation().log().z(), 1e-6);
    ++lines;
  }
  EXPECT_EQ(lines, 4) << "4 m in 9 s";
}

TEST(WriteLaserLog, relations_reach_across_the_loop) {
  const auto pairs = relation_pairs(office(), office().scan_count());
  const auto position = [](std::int64_t scan) {
    return office().world_from_body(office().time_of(scan)).translation();
  };
  int neighbors = 0, across = 0;
  for (const ScanPair& pair : pairs) {
    const double away = (position(pair.second) - position(pair.first)).norm();
    EXPECT_LT(away, 1.1);
    (pair.second - pair.first > 1000 ? across : neighbors) += 1;
  }
  EXPECT_GT(neighbors, 75);
  EXPECT_GE(across, 20) << "every half meter of the ten driven again";
}

TEST(WriteLaserLog, landmarks_are_observed_at_their_positions_and_only_when_visible) {
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  int observations = 0;
  for (std::int64_t scan = 0; scan < office().scan_count(); scan += 10) {
    const SE2 body_from_world = office().world_from_body(office().time_of(scan)).inverse();
    for (const LandmarkMeasurement& seen : sight_landmarks(office(), scan)) {
      const LaserLandmark& landmark = office().landmarks[static_cast<std::size_t>(seen.id)];
      ASSERT_EQ(landmark.id, seen.id);
      const Eigen::Vector2d in_body = body_from_world * landmark.position;
      ASSERT_LT(in_body.norm(), 6.0);
      const double bearing_error =
          std::remainder(seen.bearing - std::atan2(in_body.y(), in_body.x()), 2.0 * std::numbers::pi);
      squares += Eigen::Vector2d(std::pow(seen.range / in_body.norm() - 1.0, 2), bearing_error * bearing_error);
      ++observations;
    }
  }
  ASSERT_GT(observations, 300);
  EXPECT_NEAR(std::sqrt(squares.x() / observations), 0.02, 0.002);
  EXPECT_NEAR(std::sqrt(squares.y() / observations), std::numbers::pi / 180.0, 0.1 * std::numbers::pi / 180.0);
  // In the middle of the bare corridor there is no door, and those of the rooms are occluded.
  EXPECT_TRUE(sight_landmarks(office(), 930).empty());
}

}  // namespace
}  // namespace rastro
