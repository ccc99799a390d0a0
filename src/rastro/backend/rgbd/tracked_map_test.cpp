// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/tracked_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::bare_keyframe;
using testing::edge_of;
using testing::in_submap;
using testing::matrix_near;
using testing::pose_near;

SE3 at(double x, double yaw = 0.0) { return {SO3::exp({0.0, 0.0, yaw}), {x, 0.0, 0.0}}; }

Map base() {
  Map map;
  map.method = "rgbd";
  map.cameras.push_back({CameraKind::depth, test_room::camera(), 0.0, {}, SE3()});
  map.sessions.push_back({0, 0, "", 0, 0, {true, 0.0, "depth camera"}});
  return map;
}

/// Without keyframes from the mapper yet.
TrackedMap empty_map() { return TrackedMap(base(), std::make_shared<MemoryImages>(), false); }

/// The mapper's result for keyframe `id`, with these poses of all keyframes up to it.
MapRevision revision_of(std::int64_t id, std::vector<KeyframePose> poses) {
  MapRevision revision;
  revision.keyframe = bare_keyframe(id);
  revision.graph.poses = std::move(poses);
  revision.covariance = static_cast<double>(id + 1) * Matrix6d::Identity();
  return revision;
}

TEST(TrackedMap, KeyframesArePendingUntilTheMapperReturnsThem) {
  TrackedMap map = empty_map();
  EXPECT_EQ(map.new_submap(), 0);
  EXPECT_EQ(map.keyframe_count(), 0);
  map.add_pending(in_submap(at(1.0)), -1, Matrix6d::Identity());
  map.add_pending(in_submap(at(2.0)), -1, 2.0 * Matrix6d::Identity());
  EXPECT_EQ(map.keyframe_count(), 2);
  EXPECT_TRUE(map.keyframes().empty()) << "without features yet";
  EXPECT_THAT(map.pose(1), pose_near(at(2.0), 0.0, 0.0));
  map.apply(revision_of(0, {in_submap(at(1.5))}));
  EXPECT_EQ(map.revision(), 1);
  EXPECT_EQ(map.keyframe_count(), 2);
  EXPECT_EQ(map.keyframes().size(), 1U);
  EXPECT_THAT(map.pose(0), pose_near(at(1.5), 0.0, 0.0));
  EXPECT_THAT(map.pose(1), pose_near(at(2.0), 0.0, 0.0)) << "still as the tracker had it";
  EXPECT_THAT(map.covariance(0), matrix_near(Matrix6d(Matrix6d::Identity()), 0.0));
  EXPECT_THAT(map.covariance(1), matrix_near(Matrix6d(2.0 * Matrix6d::Identity()), 0.0));
  map.apply(revision_of(1, {in_submap(at(1.4)), in_submap(at(2.6))}));
  EXPECT_THAT(map.pose(0), pose_near(at(1.4), 0.0, 0.0)) << "a later answer moves earlier keyframes too";
  EXPECT_THAT(map.pose(1), pose_near(at(2.6), 0.0, 0.0));
  EXPECT_EQ(map.keyframe_count(), 2);
  EXPECT_EQ(map.revision(), 2);
}

TEST(TrackedMap, PendingKeyframesAreTransformedAndJoinedFromTheGivenOneOn) {
  TrackedMap map = empty_map();
  for (const double x : {1.0, 2.0, 3.0}) map.add_pending(in_submap(at(x)), -1, Matrix6d::Zero());
  map.apply(revision_of(0, {in_submap(at(1.0))}));
  const SE3 correction(SO3::exp({0.0, 0.0, M_PI / 2.0}), {0.0, 0.0, 1.0});
  map.move_pending(0, correction, 2);
  EXPECT_THAT(map.pose(0), pose_near(at(1.0), 0.0, 0.0)) << "what the mapper has is the mapper's to move";
  EXPECT_NEAR((map.pose(1).translation() - Eigen::Vector3d(0.0, 2.0, 1.0)).norm(), 0.0, 1e-12);
  map.move_pending(2, SE3(SO3(), {0.0, 0.0, 5.0}), 1);
  EXPECT_NEAR((map.pose(1).translation() - Eigen::Vector3d(0.0, 2.0, 1.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((map.pose(2).translation() - Eigen::Vector3d(0.0, 3.0, 6.0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(map.submap(0), 0);
  EXPECT_EQ(map.submap(1), 2);
  EXPECT_EQ(map.submap(2), 1);
}

TEST(TrackedMap, TheNearestKeyframesAreThoseOfTheSubmapWithFeaturesInTheirOrder) {
  TrackedMap map = empty_map();
  std::vector<KeyframePose> poses;
  const double x[] = {4.0, 1.0, 0.2, 3.0, 0.1, 2.0, 0.6, 5.0};
  for (std::int64_t id = 0; id < 8; ++id) {
    poses.push_back(in_submap(at(x[id]), id == 2 ? 1 : 0));
    map.add_pending(poses.back(), -1, Matrix6d::Zero());
    MapRevision revision = revision_of(id, poses);
    if (id == 5) revision.forgotten = {4};
    map.apply(revision);
  }
  RgbdSlamOptions options;
  options.near_distance_m = 1.0, options.near_angle_rad = 1.0;
  using Ids = std::vector<std::int64_t>;
  EXPECT_EQ(map.nearest(at(0.0), 0, options), (Ids{6, 1, 5, 3, 0})) << "five, without the one that has no features";
  EXPECT_EQ(map.nearest(at(0.0), 0, options, true), (Ids{4, 6, 1, 5, 3})) << "which is there all the same";
  EXPECT_EQ(map.nearest(at(4.6), 0, options), (Ids{7, 0, 3, 5, 1}));
  EXPECT_EQ(map.nearest(at(4.6), 1, options), Ids{2});
  EXPECT_EQ(map.nearest(at(4.6), 2, options), Ids{});
  // Turned by 1.5 rad, the nearest is as far as at 1.5 m; beyond that, the distance counts.
  EXPECT_EQ(map.nearest(at(0.0, 1.5), 0, options), (Ids{1, 6, 5, 3, 0})) << "the first two are alike: by number";
  options.near_angle_rad = 0.01;
  EXPECT_EQ(map.nearest(at(0.0, 0.1), 0, options), (Ids{0, 1, 3, 5, 6})) << "all alike by their angle";
}

TEST(TrackedMap, EveryFrameFollowsItsKeyframe) {
  TrackedMap map = empty_map();
  map.new_submap();
  map.add_pending(in_submap(at(0.0)), -1, Matrix6d::Zero());
  map.add_frame(10, 0, SE3());
  map.add_frame(20, 0, at(0.5));
  map.add_pending(in_submap(at(1.0)), -1, Matrix6d::Zero());
  map.add_frame(30, 1, SE3());
  map.add_frame(40, 1, at(0.5));
  map.apply(revision_of(0, {in_submap(at(0.0))}));
  map.apply(revision_of(1, {in_submap(at(0.0)), in_submap(at(2.0, M_PI / 2.0))}));
  const Trajectory trajectory = map.trajectory();
  ASSERT_EQ(trajectory.size(), 4U);
  const Eigen::Vector3d expected[] = {{0.0, 0.0, 0.0}, {0.5, 0.0, 0.0}, {2.0, 0.0, 0.0}, {2.0, 0.5, 0.0}};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(trajectory[k].stamp, static_cast<TimeNs>(10 * (k + 1)));
    EXPECT_NEAR((trajectory[k].world_from_body.translation() - expected[k]).norm(), 0.0, 1e-12) << k;
  }
}

TEST(TrackedMap, TheTrajectoryIsInTheOrderOfStampsWithEachOnce) {
  TrackedMap map = empty_map();
  map.new_submap();
  map.add_pending(in_submap(at(0.0)), -1, Matrix6d::Zero());
  for (const TimeNs stamp : {30, 10, 20, 10, 30}) map.add_frame(stamp, 0, at(static_cast<double>(stamp)));
  std::vector<TimeNs> stamps;
  for (const StampedPose& pose : map.trajectory()) stamps.push_back(pose.stamp);
  EXPECT_EQ(stamps, (std::vector<TimeNs>{10, 20, 30}));
}

TEST(TrackedMap, TheTrajectoryIsThatOfTheFirstSubmapAndTheLargestBecomesIt) {
  TrackedMap map = empty_map();
  for (const int submap : {0, 1, 2}) {
    EXPECT_EQ(map.new_submap(), submap);
    map.add_pending(in_submap(at(10.0 * submap), submap), -1, Matrix6d::Zero());
  }
  map.apply(revision_of(0, {in_submap(at(0.0), 0)}));
  map.apply(revision_of(1, {in_submap(at(0.0), 0), in_submap(at(10.0), 1)}));
  map.apply(revision_of(2, {in_submap(at(0.0), 0), in_submap(at(10.0), 1), in_submap(at(20.0), 2)}));
  TimeNs stamp = 0;
  for (const int keyframe : {0, 0, 1, 2, 2, 2}) map.add_frame(++stamp, keyframe, SE3());
  EXPECT_EQ(map.trajectory().size(), 2U);
  const std::int64_t before = map.revision();
  EXPECT_TRUE(map.make_largest_first());
  EXPECT_GT(map.revision(), before);
  EXPECT_EQ(map.submap(2), 0);
  EXPECT_EQ(map.submap(0), 2) << "the two change their numbers";
  EXPECT_EQ(map.submap(1), 1);
  ASSERT_EQ(map.trajectory().size(), 3U);
  EXPECT_NEAR(map.trajectory().front().world_from_body.translation().x(), 20.0, 1e-12);
  EXPECT_FALSE(map.make_largest_first()) << "it is the first already";
}

TEST(TrackedMap, AMergedSubmapIsPartOfTheTrajectory) {
  TrackedMap map = empty_map();
  for (const int submap : {0, 1}) {
    map.new_submap();
    map.add_pending(in_submap(at(10.0 * submap), submap), -1, Matrix6d::Zero());
    map.add_frame(submap + 1, submap, at(0.1));
  }
  map.apply(revision_of(0, {in_submap(at(0.0), 0)}));
  EXPECT_EQ(map.trajectory().size(), 1U);
  MapRevision merged = revision_of(1, {in_submap(at(0.0), 0), in_submap(at(1.0), 0)});
  merged.new_edges = {edge_of(0, 1, at(1.0), ConstraintKind::merge)};
  merged.graph.weights = {{0, 0.75}};
  merged.graph.covariances = {{0, 7.0 * Matrix6d::Identity()}};
  map.apply(merged);
  EXPECT_THAT(map.covariance(0), matrix_near(Matrix6d(7.0 * Matrix6d::Identity()), 0.0));
  EXPECT_THAT(map.covariance(1), matrix_near(Matrix6d(2.0 * Matrix6d::Identity()), 0.0)) << "the newest has its own";
  ASSERT_EQ(map.trajectory().size(), 2U);
  EXPECT_NEAR(map.trajectory().back().world_from_body.translation().x(), 1.1, 1e-12);
  const auto snapshot = map.snapshot();
  ASSERT_EQ(snapshot->constraints.size(), 1U);
  EXPECT_EQ(snapshot->constraints.front().kind, ConstraintKind::merge);
  EXPECT_EQ(snapshot->constraints.front().weight, 0.75);
}

TEST(TrackedMap, ASnapshotNeverChanges) {
  TrackedMap map = empty_map();
  map.new_submap();
  for (const double x : {0.0, 1.0}) map.add_pending(in_submap(at(x)), -1, Matrix6d::Zero());
  map.add_frame(1, 0, SE3());
  map.apply(revision_of(0, {in_submap(at(0.0))}));
  const auto first = map.snapshot();
  MapRevision next = revision_of(1, {in_submap(at(0.5)), in_submap(at(1.5))});
  next.new_edges = {edge_of(0, 1, at(1.0)), edge_of(0, 1, at(1.0), ConstraintKind::proximity),
                    edge_of(0, 1, at(1.0), ConstraintKind::loop)};
  next.graph.weights = {{1, 0.5}, {2, 0.25}};
  map.apply(next);
  map.add_frame(2, 1, SE3());
  const auto second = map.snapshot();
  ASSERT_EQ(first->keyframes.size(), 1U);
  EXPECT_EQ(first->keyframes.front().world_from_camera.translation().x(), 0.0);
  EXPECT_TRUE(first->constraints.empty());
  EXPECT_EQ(trajectory_of(*first).size(), 1U);
  EXPECT_LT(first->revision, second->revision);
  ASSERT_EQ(second->keyframes.size(), 2U);
  EXPECT_EQ(second->keyframes.back().stamp, 1000) << "of the keyframe itself";
  ASSERT_EQ(second->constraints.size(), 3U);
  const double weights[] = {1.0, 0.5, 0.25};
  for (std::size_t e = 0; e < 3; ++e) {
    EXPECT_EQ(second->constraints[e].kind, next.new_edges[e].kind);
    EXPECT_EQ(second->constraints[e].weight, weights[e]);
  }
  EXPECT_EQ(second->cameras.at(0).intrinsics.fx, 260.0) << "and what all share";
  EXPECT_EQ(second->sessions.size(), 1U);
  for (const auto& snapshot : {first, second}) {
    EXPECT_EQ(contradiction_in(*snapshot), "");
    ASSERT_TRUE(images_of(*snapshot));
    EXPECT_EQ(snapshot->layer<ImageLayer>()->keyframes.size(), snapshot->keyframes.size());
    EXPECT_EQ(snapshot->layer<FeatureLayer>()->of.size(), snapshot->keyframes.size());
  }
}

TEST(TrackedMap, DroppedFeaturesAreRemovedHereToo) {
  TrackedMap map = empty_map();
  map.new_submap();
  for (const double x : {0.0, 1.0}) map.add_pending(in_submap(at(x)), -1, Matrix6d::Zero());
  map.apply(revision_of(0, {in_submap(at(0.0))}));
  const auto before = map.snapshot();
  MapRevision next = revision_of(1, {in_submap(at(0.0)), in_submap(at(1.0))});
  next.forgotten = {0};
  map.apply(next);
  EXPECT_EQ(map.keyframes()[0]->features.size(), 0U);
  EXPECT_EQ(map.keyframes()[0]->id, 0);
  EXPECT_EQ(map.keyframes()[0]->features.length, before->layer<FeatureLayer>()->find(0)->features.length);
  EXPECT_EQ(map.keyframes()[1]->features.size(), 1U);
  EXPECT_EQ(before->layer<FeatureLayer>()->find(0)->features.size(), 1U) << "an older snapshot keeps its own";
  EXPECT_EQ(map.snapshot()->layer<FeatureLayer>()->find(0)->features.size(), 0U);
}

TEST(TrackedMap, WhereAGivenMapIsLocalizedInPosesInItsOtherSubmapsAreUnknown) {
  Map given = make_test_map(4);
  given.keyframes[3].submap = 1;
  for (const bool localized : {true, false}) {
    TrackedMap map(given, images_of(given), localized);
    map.add_frame(77, 3, SE3());
    EXPECT_EQ(map.trajectory().size(), localized ? 0U : 1U);
  }
}

TEST(TrackedMap, AGivenMapIsNotChanged) {
  const Map given = make_test_map(4);
  TrackedMap map(given, images_of(given), true);
  EXPECT_EQ(map.keyframe_count(), 4);
  EXPECT_EQ(map.keyframes().size(), 4U);
  EXPECT_EQ(map.submap_count(), 1);
  EXPECT_EQ(map.new_submap(), 1);
  map.add_pending(in_submap(at(0.5)), -1, Matrix6d::Zero());
  std::vector<KeyframePose> poses;
  for (const Keyframe& keyframe : given.keyframes) poses.push_back({keyframe.world_from_camera, keyframe.submap});
  poses.push_back(in_submap(at(0.7)));
  map.apply(revision_of(4, poses));
  map.add_frame(77, 4, SE3());
  const auto snapshot = map.snapshot();
  EXPECT_EQ(snapshot->keyframes.size(), 4U) << "the map is as it was given";
  EXPECT_EQ(snapshot->frames.size(), given.frames.size());
  EXPECT_EQ(snapshot->constraints.size(), given.constraints.size());
  EXPECT_EQ(snapshot->layer<FeatureLayer>(), given.layer<FeatureLayer>());
  ASSERT_EQ(map.trajectory().size(), 1U) << "the frames found in it";
  EXPECT_NEAR(map.trajectory().front().world_from_body.translation().x(), 0.7, 1e-12);
  EXPECT_FALSE(map.make_largest_first());
}

}  // namespace
}  // namespace rastro
