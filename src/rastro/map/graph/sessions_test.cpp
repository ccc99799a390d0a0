// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/sessions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rastro {
namespace {

using ::testing::ElementsAre;

void add_session(Map& map, std::vector<TimeNs> stamps, double height, bool numbered_on = true) {
  const int session = static_cast<int>(map.sessions.size());
  map.sessions.push_back({0, session, "", stamps.front(), stamps.back(), {}});
  const KeyframeId id = numbered_on || session == 0 ? session : keyframe_id({0, session, 0});
  map.keyframes.push_back({id, 0, stamps.front(), 0, SE3(SO3(), {0.0, 0.0, height}), 0, no_keyframe, 1.0});
  // Relative to the keyframe of the first session, as where the map is known already.
  const SE3 first_from_frame(SO3(), {0.0, 0.0, height - map.keyframes.front().world_from_camera.translation().z()});
  for (const TimeNs stamp : stamps) map.frames.push_back({stamp, map.keyframes.front().id, first_from_frame});
}

std::vector<TimeNs> stamps_of(const Trajectory& trajectory) {
  std::vector<TimeNs> stamps;
  for (const StampedPose& pose : trajectory) stamps.push_back(pose.stamp);
  return stamps;
}

std::vector<double> heights_of(const Trajectory& trajectory) {
  std::vector<double> heights;
  for (const StampedPose& pose : trajectory) heights.push_back(pose.world_from_body.translation().z());
  return heights;
}

TEST(Sessions, FramesBelongToTheNextWhereTheClockJumpsBack) {
  Map map;
  add_session(map, {0, 100, 200}, 1.0);
  add_session(map, {50, 100, 300}, 2.0);
  add_session(map, {300, 400}, 3.0);
  EXPECT_THAT(sessions_of_frames(map), ElementsAre(0, 0, 0, 1, 1, 1, 2, 2));
  EXPECT_TRUE(sessions_of_frames(Map()).empty());
}

TEST(Sessions, FramesBelongToTheNextWhereTheyLeaveTheSpan) {
  Map map;
  add_session(map, {0, 100}, 1.0);
  add_session(map, {500, 600}, 2.0);
  EXPECT_THAT(sessions_of_frames(map), ElementsAre(0, 0, 1, 1));
  map.frames[1].stamp = 110;
  EXPECT_THAT(sessions_of_frames(map), ElementsAre(0, 0, 1, 1)) << "a stamp of no session";
}

TEST(Sessions, KeyframesBelongToThoseOfTheirIdsOrStamps) {
  for (const bool numbered_on : {true, false}) {
    Map map;
    add_session(map, {0, 100}, 1.0, numbered_on);
    add_session(map, {50, 100}, 2.0, numbered_on);
    map.keyframes[1].stamp = numbered_on ? 0 : 50;
    EXPECT_THAT(sessions_of_keyframes(map), ElementsAre(0, 1)) << numbered_on;
  }
}

TEST(Sessions, ThoseOneAfterTheOtherAreOneTrajectory) {
  Map map;
  add_session(map, {500, 600}, 1.0);
  add_session(map, {100, 200}, 2.0);
  EXPECT_FALSE(sessions_overlap(map));
  EXPECT_THAT(stamps_of(trajectory_of(map)), ElementsAre(100, 200, 500, 600));
  EXPECT_THAT(heights_of(trajectory_of(map)), ElementsAre(2.0, 2.0, 1.0, 1.0));
  EXPECT_THAT(stamps_of(trajectory_of_session(map, 0)), ElementsAre(500, 600));
}

TEST(Sessions, WhereTheyOverlapTheTrajectoryIsTheLastOne) {
  Map map;
  add_session(map, {0, 100, 200}, 1.0);
  add_session(map, {50, 100, 150}, 2.0);
  EXPECT_TRUE(sessions_overlap(map));
  EXPECT_THAT(stamps_of(trajectory_of(map)), ElementsAre(50, 100, 150));
  EXPECT_THAT(heights_of(trajectory_of(map)), ElementsAre(2.0, 2.0, 2.0));
  EXPECT_THAT(heights_of(trajectory_of_session(map, 0)), ElementsAre(1.0, 1.0, 1.0));
  EXPECT_TRUE(trajectory_of(map, 1).empty());
}

TEST(Sessions, InASubmapItIsTheLastOneThatHasPosesThere) {
  Map map;
  add_session(map, {0, 100, 200}, 1.0);
  add_session(map, {50, 100, 150}, 2.0);
  map.keyframes[1].submap = 1;
  for (std::size_t k = 3; k < 6; ++k) map.frames[k].keyframe = map.keyframes[1].id;
  EXPECT_THAT(stamps_of(trajectory_of(map)), ElementsAre(0, 100, 200));
  EXPECT_THAT(stamps_of(trajectory_of(map, 1)), ElementsAre(50, 100, 150));
  EXPECT_THAT(stamps_of(trajectory_of(map, std::set<int>{0, 1})), ElementsAre(50, 100, 150));
}

TEST(Sessions, ASessionWithoutFramesOverlapsNone) {
  Map map;
  add_session(map, {0, 100}, 1.0);
  map.sessions.push_back({0, 1, "", 0, 0, {}});
  EXPECT_FALSE(sessions_overlap(map));
  EXPECT_THAT(stamps_of(trajectory_of(map)), ElementsAre(0, 100));
}

}  // namespace
}  // namespace rastro
