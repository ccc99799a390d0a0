// SPDX-License-Identifier: Apache-2.0
// A map of one session that later ones go on with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "rastro/backend/rgbd/rgbd_slam.h"
#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/slam/rtabmap/appearance_search.h"

namespace rastro {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::looking;
using testing::pose_near;
using testing::room_frame;

/// SLAM of the test room, from whose middle the camera looks around.
class RoomSlam {
 public:
  explicit RoomSlam(std::shared_ptr<const Map> map = nullptr) {
    RtabmapOptions options;
    options.rgbd.lost_frames = options.rgbd.relocalize_every = 2;
    options.rgbd.backend_delay_frames = 1;
    SlamContext context;
    context.map = std::move(map);
    context.extend_map = context.map != nullptr;
    const auto search = [options] { return std::make_unique<AppearanceSearch>(options, AppearanceSearch::Means()); };
    slam_ = std::make_unique<RgbdSlam>("rtabmap", options.rgbd, test_room::camera(), context, search);
  }
  static SE3 at(double yaw) { return looking({-0.2, 0.1, 1.2}, yaw); }
  void look(double from_rad, double to_rad) {
    constexpr double step_rad = 0.09;
    const int steps = static_cast<int>(std::abs(to_rad - from_rad) / step_rad);
    for (int k = 0; k <= steps; ++k) show(at(from_rad + (to_rad - from_rad) * k / steps));
  }
  std::shared_ptr<const Map> finish() {
    for (const SlamEvent& event : slam_->finish()) last_said_ = event.detail;
    return slam_->snapshot();
  }
  Trajectory trajectory() const { return slam_->trajectory(); }
  std::size_t shown() const { return static_cast<std::size_t>(shown_); }
  const std::string& last_said() const { return last_said_; }

 private:
  void show(const SE3& world_from_camera) { slam_->process(room_frame(world_from_camera, shown_++)); }

  std::unique_ptr<RgbdSlam> slam_;
  std::int64_t shown_ = 0;
  std::string last_said_;
};

std::set<int> submaps_of(const Map& map) {
  std::set<int> submaps;
  for (const Keyframe& keyframe : map.keyframes) submaps.insert(keyframe.submap);
  return submaps;
}

constexpr double first_yaw = -0.4, second_yaw = M_PI - 0.4;

/// Of two walls, with a loss between them.
std::shared_ptr<const Map> two_submaps() {
  static const auto made = [] {
    RoomSlam first;
    first.look(first_yaw, 0.4);
    first.look(second_yaw, M_PI + 0.2);
    return first.finish();
  }();
  return made;
}

TEST(ContinuedMap, ASessionThatSeesBothSubmapsOfAnEarlierOneJoinsThem) {
  ASSERT_THAT(submaps_of(*two_submaps()), ElementsAre(0, 1));
  RoomSlam second(two_submaps());
  second.look(M_PI, 0.0);  // first what the second submap shows
  const auto map = second.finish();
  EXPECT_THAT(submaps_of(*map), ElementsAre(0));
  ASSERT_EQ(second.trajectory().size(), second.shown());
  const SE3 moved = RoomSlam::at(first_yaw).inverse() * RoomSlam::at(0.0);
  EXPECT_THAT(second.trajectory().back().world_from_body, pose_near(moved, 0.03, 0.02));
}

TEST(ContinuedMap, ASessionThatSeesTheSecondSubmapAloneHasItsTrajectoryThere) {
  RoomSlam second(two_submaps());
  second.look(M_PI - 0.1, M_PI + 0.2);
  const auto map = second.finish();
  EXPECT_THAT(submaps_of(*map), ElementsAre(0, 1)) << "it joined the second";
  ASSERT_EQ(second.trajectory().size(), second.shown());
  const SE3 seen = second.trajectory().front().world_from_body.inverse() * second.trajectory().back().world_from_body;
  EXPECT_THAT(seen, pose_near(RoomSlam::at(M_PI - 0.1).inverse() * RoomSlam::at(M_PI + 0.2), 0.03, 0.02));
  EXPECT_THAT(second.last_said(), HasSubstr("1 is not connected to the first"));
}

/// The latest keyframes are compared anyway, but these have their features in long-term memory.
TEST(ContinuedMap, WhatTheEarlierSessionSawLastIsRecognizedToo) {
  RoomSlam first;
  first.look(0.0, 0.1);
  const auto before = first.finish();
  ASSERT_LE(before->keyframes.size(), 2U);
  RoomSlam second(before);
  second.look(0.0, 0.1);
  EXPECT_THAT(submaps_of(*second.finish()), ElementsAre(0));
}

/// With the features of its keyframes in place of signatures.
std::shared_ptr<const Map> as_made_by_rgbd(const Map& made) {
  auto map = std::make_shared<Map>(made);
  auto features = std::make_shared<FeatureLayer>();
  for (const Keyframe& keyframe : made.keyframes)
    features->of[keyframe.id] = with_id(*made.layer<SignatureLayer>()->store->read(keyframe.id).image, keyframe.id);
  map->method = "rgbd";
  map->layers.put<FeatureLayer>(std::move(features));
  map->layers.put(SignatureLayer::layer_name, nullptr);
  return map;
}

TEST(ContinuedMap, OneMadeByRgbdIsRecognizedToo) {
  RoomSlam first;
  first.look(0.0, 0.1);
  RoomSlam second(as_made_by_rgbd(*first.finish()));
  second.look(0.0, 0.1);
  const auto map = second.finish();
  EXPECT_THAT(submaps_of(*map), ElementsAre(0));
  EXPECT_GT(map->layer<SignatureLayer>()->store->read(0).image->features.size(), 0U);
}

TEST(ContinuedMap, SessionsAreAppendedAndEveryKeyframeHasItsOwnId) {
  const auto before = two_submaps();
  RoomSlam second(before);
  second.look(0.0, 0.3);
  const auto map = second.finish();
  ASSERT_EQ(map->sessions.size(), 2U);
  EXPECT_EQ(map->sessions[0].session, 0);
  EXPECT_EQ(map->sessions[1].session, 1);
  EXPECT_EQ(map->sessions[1].first_stamp, room_frame(SE3(), 0).stamp);
  EXPECT_GT(map->keyframes.size(), before->keyframes.size());
  EXPECT_EQ(contradiction_in(*map), "") << "ids ascend, so that none is there twice";
  for (std::size_t k = 0; k < before->keyframes.size(); ++k) {
    EXPECT_EQ(map->keyframes[k].id, before->keyframes[k].id);
    EXPECT_EQ(map->keyframes[k].stamp, before->keyframes[k].stamp);
  }
  EXPECT_EQ(map->frames.size(), before->frames.size() + second.shown());
}

}  // namespace
}  // namespace rastro
