// SPDX-License-Identifier: Apache-2.0
// What a map in the making says of its keyframes, edges and frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/backend/rgbd/given_map.h"
#include "rastro/backend/rgbd/rgbd_testing.h"
#include "rastro/backend/rgbd/tracked_map.h"

namespace rastro {
namespace {

using testing::bare_keyframe;
using testing::edge_of;
using testing::in_submap;
using testing::pose_near;

SE3 shifted(double x) { return {SO3(), {x, 0.0, 0.0}}; }

TrackedMap unfilled_map() {
  return TrackedMap(base_map("rgbd", {}, test_room::camera()), std::make_shared<MemoryImages>(), false);
}

/// The mapper's result for keyframe 0, at the origin.
MapRevision first_keyframe() {
  MapRevision revision;
  revision.keyframe = bare_keyframe(0);
  revision.graph.poses = {in_submap(SE3())};
  return revision;
}

TEST(TrackedMap, KeyframesAreConnectedByAnEdgeBetweenThemInEitherDirection) {
  TrackedMap map = unfilled_map();
  map.new_submap();
  map.add_pending(in_submap(shifted(0.0)), -1, Matrix6d::Zero());
  MapRevision revision = first_keyframe();
  revision.new_edges = {edge_of(0, 1, shifted(1.0)), edge_of(3, 1, shifted(-2.0))};
  map.apply(revision);
  using Pairs = std::vector<std::pair<std::int64_t, std::int64_t>>;
  Pairs connected;
  for (std::int64_t a = 0; a < 4; ++a) {
    for (std::int64_t b = 0; b < 4; ++b)
      if (map.are_connected(a, b)) connected.emplace_back(a, b);
  }
  EXPECT_EQ(connected, (Pairs{{0, 1}, {1, 0}, {1, 3}, {3, 1}}));
}

/// Frames of keyframes that the mapper has not returned yet are left out.
TEST(TrackedMap, ASnapshotSaysWhenItsFramesWereAndWhatItsKeyframesAre) {
  TrackedMap map = unfilled_map();
  map.new_submap();
  EXPECT_EQ(map.snapshot()->sessions[0].last_stamp, 0) << "none yet";
  for (const double x : {0.0, 1.0}) map.add_pending(in_submap(shifted(x)), -1, Matrix6d::Zero());
  for (const TimeNs stamp : {5, 7, 9}) map.add_frame(stamp, stamp == 9 ? 1 : 0, shifted(0.1));
  map.apply(first_keyframe());
  const auto snapshot = map.snapshot();
  ASSERT_EQ(snapshot->frames.size(), 2U);
  EXPECT_EQ(snapshot->frames[1].stamp, 7);
  EXPECT_EQ(snapshot->frames[1].keyframe, 0);
  EXPECT_THAT(snapshot->frames[1].keyframe_from_camera, pose_near(shifted(0.1), 0.0, 0.0));
  EXPECT_EQ(snapshot->sessions[0].first_stamp, 5);
  EXPECT_EQ(snapshot->sessions[0].last_stamp, 7);
  const Keyframe& keyframe = snapshot->keyframes.front();
  EXPECT_EQ(keyframe.frame, 0);
  EXPECT_EQ(keyframe.camera, 0);
  EXPECT_EQ(keyframe.parent, no_keyframe);
  EXPECT_EQ(keyframe.weight, 1.0);
  EXPECT_EQ(snapshot->revision, 1);
}

}  // namespace
}  // namespace rastro
