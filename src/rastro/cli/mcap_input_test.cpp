// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/mcap_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "rastro/cli/scene_input.h"
#include "rastro/map/images/room_map_testing.h"
#include "rastro/map/landmarks/landmark_map_testing.h"

namespace rastro::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

ExportInput input_of(Map map) {
  ExportInput input;
  input.path = "room";
  input.trajectory = trajectory_of(map);
  input.map = std::make_shared<const Map>(std::move(map));
  return input;
}

McapRun run_of(const ExportInput& input, const RunRecord& record = {}, int submap = 0) {
  TaskPool pool(1);
  ViewSceneOptions options;
  options.submap = submap;
  return mcap_run_of(input, record, view_scene_of(input, record, options, pool, {}), submap);
}

std::vector<std::string> kinds_of(const McapRun& run) {
  std::vector<std::string> kinds;
  for (const McapRun::Note& note : run.notes) kinds.push_back(note.kind);
  return kinds;
}

TEST(McapInput, TakesPosesAndStampsAsTheyAre) {
  const ExportInput input = input_of(make_landmark_test_map());
  const McapRun run = run_of(input);
  ASSERT_EQ(run.trajectory.size(), input.trajectory.size());
  for (std::size_t k = 0; k < run.trajectory.size(); ++k) {
    EXPECT_EQ(run.trajectory[k].stamp, input.trajectory[k].stamp);
    EXPECT_EQ(run.trajectory[k].world_from_body.translation(), input.trajectory[k].world_from_body.translation());
  }
  ASSERT_EQ(run.keyframes.size(), input.map->keyframes.size());
  EXPECT_EQ(run.keyframes[1].pose.stamp, input.map->keyframes[1].stamp);
  EXPECT_TRUE(run.of_camera);
  ASSERT_TRUE(run.camera.has_value());
  EXPECT_EQ(run.camera->fx, input.map->cameras.front().intrinsics.fx);
}

TEST(McapInput, NamesKeyframesNumberedOnByTheirSessions) {
  Map map = make_test_map(3);
  const TimeNs first = map.keyframes.front().stamp, last = map.keyframes.back().stamp;
  map.sessions = {{0, 0, "first", first, last, {}}, {0, 1, "second", first, last, {}}};
  map.keyframes[2].stamp = first;
  std::vector<std::string> names;
  for (const auto& keyframe : run_of(input_of(std::move(map))).keyframes) names.push_back(keyframe.name);
  EXPECT_THAT(names, ElementsAre("0/0/0", "0/0/1", "0/1/2"));
}

TEST(McapInput, TakesLayersUnderTheirNames) {
  const McapRun run = run_of(input_of(make_landmark_test_map()));
  ASSERT_FALSE(run.points.empty());
  EXPECT_EQ(run.points.front().name, "landmarks");
  EXPECT_FALSE(run.edges.empty());
  for (const McapRun::Edges& edges : run.edges)
    for (const auto& pair : edges.pairs) EXPECT_LT(std::max(pair[0], pair[1]), run.keyframes.size()) << edges.name;
}

TEST(McapInput, TakesTheImagesOfTheMap) {
  const ExportInput input = input_of(make_test_map(2));
  const McapRun run = run_of(input);
  ASSERT_EQ(run.images.size(), 2U);
  EXPECT_EQ(run.images[1].stamp, input.map->keyframes[1].stamp);
  EXPECT_TRUE(run.images[1].jpeg().starts_with("\xff\xd8")) << "a JPEG";
}

TEST(McapInput, EllipsoidsKeepTheirCovariance) {
  RunRecord record;
  const ExportInput input = input_of(make_landmark_test_map());
  const Eigen::Matrix3d covariance = Eigen::Vector3d(0.04, 0.01, 0.09).asDiagonal();
  record.uncertainties = {{input.trajectory.front().stamp, covariance}};
  const McapRun run = run_of(input, record);
  const auto found = std::find_if(run.ellipsoids.begin(), run.ellipsoids.end(),
                                  [](const auto& each) { return each.name == "pose_covariances"; });
  ASSERT_NE(found, run.ellipsoids.end());
  EXPECT_TRUE(found->covariances.at(0).isApprox(covariance, 1e-5)) << found->covariances.at(0);
}

TEST(McapInput, NotesAreEventsAndUntoldChangesOfTheState) {
  RunRecord record;
  record.frames = {
      {0, 100, "initializing", 1.0}, {1, 200, "tracking", 1.0}, {2, 300, "tracking", 1.0}, {3, 400, "lost", 1.0}};
  record.events = {{1, "keyframe", "0"}, {3, "lost", "few_inliers: 3 of 40"}, {9, "keyframe", "no such frame"}};
  const McapRun run = run_of(input_of(make_landmark_test_map()), record);
  EXPECT_THAT(kinds_of(run), ElementsAre("initializing", "tracking", "keyframe", "lost"));
  EXPECT_EQ(run.notes[3].stamp, 400);
  EXPECT_EQ(run.notes[3].text, "few_inliers: 3 of 40");
  EXPECT_EQ(run.notes[3].level, McapRun::Level::error);
}

TEST(McapInput, SaysWhatItIsOf) {
  const McapRun run = run_of(input_of(make_landmark_test_map()));
  EXPECT_EQ(run.facts.at("name"), "room");
  EXPECT_THAT(run.facts.at("frames"), HasSubstr("camera: x right"));
  ExportInput poses;
  poses.path = "poses.txt";
  poses.trajectory = {{0, SE3()}, {1, SE3(SO3(), {1.0, 0.0, 0.0})}};
  const McapRun level = run_of(poses);
  EXPECT_FALSE(level.of_camera) << "both poses are level";
  EXPECT_EQ(level.up, Eigen::Vector3d::UnitZ());
}

}  // namespace
}  // namespace rastro::cli
