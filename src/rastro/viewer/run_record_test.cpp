// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/run_record.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rastro {
namespace {

constexpr TimeNs first_stamp = 1'403'715'273'262'142'976;  // of a recording: a double does not hold all its digits

TimeNs stamp_of(int frame) { return first_stamp + frame * 50'000'000; }

/// Frames 1, 2, 3 along x; frame 0 has no pose.
RunRecord record() {
  RunRecord record;
  for (int frame = 1; frame <= 3; ++frame)
    record.trajectory.push_back({stamp_of(frame), SE3(SO3(), {1.0 * frame, 0.0, 0.0})});
  record.online.push_back({stamp_of(1), SE3(SO3(), {1.5, 0.0, 0.0})});
  record.online.push_back({stamp_of(3), SE3(SO3(), {3.5, 0.0, 0.0})});
  const char* states[] = {"initializing", "tracking", "lost", "of another kind"};
  for (int frame = 0; frame <= 3; ++frame)
    record.frames.push_back({frame, stamp_of(frame), states[frame], 10.0 + frame});
  RunRecord::Uncertainty uncertainty;
  uncertainty.stamp = stamp_of(2);
  uncertainty.covariance = Eigen::Vector3d(0.01, 0.02, 0.06).asDiagonal();
  record.uncertainties.push_back(uncertainty);
  record.truth.push_back({stamp_of(3), {3.0, 4.0, 0.0}});
  record.events = {{0, "initializing", "first_frame"}, {2, "loop_closed", "with 1"}, {99, "keyframe", "was skipped"}};
  return record;
}

TEST(RunRecord, JoinsWhatItHasByStamp) {
  ViewScene scene;
  add_run(record(), scene);
  const SceneFrames& frames = scene.frames;
  EXPECT_EQ(frames.positions, (std::vector<float>{1, 0, 0, 2, 0, 0, 3, 0, 0}));
  EXPECT_EQ(frames.orientations.size(), 12U);
  ASSERT_EQ(frames.states.size(), 3U);
  EXPECT_EQ(scene_state_names().at(frames.states[0]), "tracking");
  EXPECT_EQ(scene_state_names().at(frames.states[1]), "lost");
  EXPECT_EQ(scene_state_names().at(frames.states[2]), "unknown");
  EXPECT_EQ(frames.milliseconds, (std::vector<float>{11, 12, 13}));
  ASSERT_EQ(frames.online.size(), 9U);
  EXPECT_EQ(frames.online[0], 1.5F);
  EXPECT_TRUE(std::isnan(frames.online[3])) << "no pose was given for it first";
  EXPECT_EQ(frames.online[6], 3.5F);
}

TEST(RunRecord, HasUncertaintiesTruthAndEvents) {
  ViewScene scene;
  add_run(record(), scene);
  const SceneFrames& frames = scene.frames;
  EXPECT_TRUE(std::isnan(frames.sigmas[0]));
  EXPECT_FLOAT_EQ(frames.sigmas[1], 0.3F);
  const auto& ellipsoids = std::get<SceneEllipsoids>(scene.layers.at(0));
  EXPECT_EQ(ellipsoids.centers, (std::vector<float>{2, 0, 0})) << "at the final pose";
  EXPECT_TRUE(std::isnan(frames.errors[0]));
  EXPECT_FLOAT_EQ(frames.errors[2], 4.0F) << "in the unit of the map, as all lengths are";
  EXPECT_EQ(frames.truth[7], 4.0F);
  ASSERT_EQ(scene.events.size(), 2U);
  EXPECT_EQ(scene.events[0].frame, SceneEvent::no_pose);
  EXPECT_EQ(scene.events[0].stamp_s, to_seconds(stamp_of(0)));
  EXPECT_EQ(scene.events[1].frame, 1) << "the row of the frame";
  EXPECT_EQ(scene.events[1].kind, "loop_closed");
}

TEST(RunRecord, KeepsTheFramesOfTheMapWhereTheyAreNoFewer) {
  ViewScene scene;
  scene.frames.stamps_s = {to_seconds(stamp_of(1)), to_seconds(stamp_of(2)), to_seconds(stamp_of(3))};
  scene.frames.positions.assign(9, 7.0F);
  scene.frames.orientations.assign(12, 0.5F);
  add_run(record(), scene);
  EXPECT_EQ(scene.frames.positions[0], 7.0F);
  EXPECT_EQ(scene.frames.milliseconds[2], 13.0F);
}

TEST(RunRecord, AddsNothingOfAnEmptyRun) {
  ViewScene scene;
  add_run({}, scene);
  EXPECT_TRUE(scene.frames.stamps_s.empty());
  EXPECT_TRUE(scene.frames.states.empty());
  EXPECT_TRUE(scene.layers.empty());
}

}  // namespace
}  // namespace rastro
