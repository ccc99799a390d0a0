// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/pose_chain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/random.h"
#include "rastro/math/math_testing.h"
#include "rastro/odometry/features/local_map.h"
#include "rastro/odometry/features/options.h"

namespace rastro {
namespace {

using testing::pose_near;

constexpr TimeNs step = 33'333'333;

/// A camera with constant linear and angular velocity.
SE3 world_from_camera(int frame) {
  const SO3 rotation = SO3::exp({0.0, 0.03 * frame, 0.0});
  return {rotation, {0.1 * frame, 0.02 * frame, 0.3 * frame}};
}

SE3 camera_from_world(int frame) { return world_from_camera(frame).inverse(); }

class PoseChainTest : public ::testing::Test {
 protected:
  /// Exact poses of frames first .. last, relative to a keyframe at the first of them.
  void follow(int first, int last) {
    const std::size_t keyframe = map_.add_keyframe(first * step, camera_from_world(first), {});
    for (int k = first; k <= last; ++k) chain_.add(k * step, keyframe, camera_from_world(k) * world_from_camera(first));
  }

  FeaturesOptions options_;
  LocalMap map_{options_, 500.0};
  PoseChain chain_;
};

TEST_F(PoseChainTest, WithoutFramesEverythingIsAtTheOrigin) {
  EXPECT_THAT(chain_.last_camera_from_world(map_), pose_near(SE3(), 0.0, 0.0));
  EXPECT_THAT(chain_.predicted(5 * step, map_), pose_near(SE3(), 0.0, 0.0));
  EXPECT_TRUE(chain_.trajectory(map_).empty());
  EXPECT_FALSE(chain_.length_between(0, step, map_));
}

TEST_F(PoseChainTest, AConstantVelocityIsPredictedExactly) {
  follow(0, 3);
  EXPECT_THAT(chain_.predicted(4 * step, map_), pose_near(camera_from_world(4), 1e-9, 1e-9));
  EXPECT_THAT(chain_.predicted(5 * step, map_), pose_near(camera_from_world(5), 1e-9, 1e-9));
  const SE3 later = chain_.predicted(8 * step, map_).inverse();
  EXPECT_LT((later.translation() - world_from_camera(8).translation()).norm(), 1e-6) << "the translation continues";
  EXPECT_LT((later.rotation().inverse() * world_from_camera(5).rotation()).log().norm(), 1e-9)
      << "the rotation for two frames only";
  EXPECT_THAT(chain_.predicted(2 * step, map_), pose_near(camera_from_world(3), 1e-9, 1e-9))
      << "never backwards in time";
  const double length = (world_from_camera(1).translation() - world_from_camera(0).translation()).norm();
  EXPECT_NEAR(*chain_.length_between(3 * step, 5 * step, map_), 2.0 * length, 1e-9);
}

TEST_F(PoseChainTest, AfterAStandstillTheSpeedBeforeItGivesTheScale) {
  follow(0, 3);
  for (int k = 4; k < 9; ++k) chain_.repeat(k * step);
  const double length = (world_from_camera(3).translation() - world_from_camera(2).translation()).norm();
  ASSERT_TRUE(chain_.length_between(8 * step, 10 * step, map_));
  EXPECT_NEAR(*chain_.length_between(8 * step, 10 * step, map_), 2.0 * length, 1e-9);
}

TEST_F(PoseChainTest, PosesFollowTheirKeyframe) {
  const std::size_t before = map_.add_keyframe(0, camera_from_world(0), {});
  chain_.add(0, before, SE3());
  const std::size_t record = chain_.add_unknown(step);
  const std::size_t keyframe = map_.add_keyframe(step, camera_from_world(5), {});
  chain_.set(record, keyframe, SE3());
  chain_.add_unknown(2 * step);
  chain_.set_last(keyframe, camera_from_world(7) * world_from_camera(5));
  EXPECT_THAT(chain_.last_camera_from_world(map_), pose_near(camera_from_world(7), 1e-9, 1e-9));
  EXPECT_THAT(chain_.camera_from_world_at(step, map_), pose_near(camera_from_world(5), 1e-9, 1e-9));
  EXPECT_THAT(chain_.camera_from_world_at(0, map_), pose_near(camera_from_world(0), 1e-9, 1e-9));
}

TEST_F(PoseChainTest, UnknownPosesAreInterpolated) {
  chain_.add_unknown(-step);
  follow(0, 1);
  chain_.add_unknown(2 * step);
  chain_.add_unknown(3 * step);
  const std::size_t keyframe = map_.add_keyframe(4 * step, camera_from_world(4), {});
  chain_.add(4 * step, keyframe, SE3());
  chain_.add_unknown(5 * step);
  const Trajectory trajectory = chain_.trajectory(map_);
  ASSERT_EQ(trajectory.size(), 7U);
  for (std::size_t k = 0; k < 7; ++k) EXPECT_EQ(trajectory[k].stamp, (static_cast<TimeNs>(k) - 1) * step);
  EXPECT_THAT(trajectory[0].world_from_body, pose_near(world_from_camera(0), 1e-9, 1e-9)) << "before all: the first";
  for (const int k : {2, 3}) {
    const SE3 between = interpolate(world_from_camera(1), world_from_camera(4), (k - 1) / 3.0);
    EXPECT_THAT(trajectory[static_cast<std::size_t>(k) + 1].world_from_body, pose_near(between, 1e-6, 1e-6)) << k;
  }
  EXPECT_THAT(trajectory[6].world_from_body, pose_near(world_from_camera(4), 1e-9, 1e-9)) << "after all: the last";
}

TEST_F(PoseChainTest, PredictionsDoNotBuildOnPredictions) {
  follow(0, 2);
  chain_.add_predicted(3 * step, map_);
  chain_.add_predicted(6 * step, map_);
  EXPECT_THAT(chain_.predicted(4 * step, map_), pose_near(camera_from_world(4), 1e-9, 1e-9))
      << "still from the last two estimated poses";
  chain_.repeat(7 * step);
  const Trajectory trajectory = chain_.trajectory(map_);
  ASSERT_EQ(trajectory.size(), 6U);
  EXPECT_THAT(trajectory[5].world_from_body, pose_near(trajectory[4].world_from_body, 0.0, 1e-12)) << "a frame twice";
  EXPECT_THAT(trajectory[3].world_from_body, pose_near(world_from_camera(3), 1e-9, 1e-9));
}

TEST_F(PoseChainTest, UnderRepeatedImagesThePoseStaysAndTimeDoesNotCount) {
  follow(0, 2);
  for (int k = 3; k < 40; ++k) {
    chain_.add_repeated(k * step);
    EXPECT_THAT(chain_.last_camera_from_world(map_), pose_near(camera_from_world(2), 1e-9, 1e-9)) << k;
  }
  EXPECT_THAT(chain_.predicted(40 * step, map_), pose_near(camera_from_world(3), 1e-9, 1e-9));
  chain_.add_unknown(40 * step);
  EXPECT_THAT(chain_.last_camera_from_world(map_), pose_near(camera_from_world(3), 1e-9, 1e-9));
  chain_.add_repeated(41 * step);
  EXPECT_THAT(chain_.last_camera_from_world(map_), pose_near(camera_from_world(2), 1e-9, 1e-9))
      << "the image of before the unknown one";
  chain_.repeat(42 * step);
  EXPECT_THAT(chain_.last_camera_from_world(map_), pose_near(camera_from_world(2), 1e-9, 1e-9)) << "the last known";
  EXPECT_EQ(chain_.trajectory(map_).size(), 43U);
}

TEST_F(PoseChainTest, PosesMayBecomeKnownInAnyOrder) {
  const std::size_t keyframe = map_.add_keyframe(0, camera_from_world(0), {});
  for (int k = 0; k < 6; ++k) chain_.add_unknown(k * step);
  const auto set = [&](int k) {
    chain_.set(static_cast<std::size_t>(k), keyframe, camera_from_world(k) * world_from_camera(0));
  };
  for (const int k : {0, 5, 2, 4}) set(k);
  EXPECT_THAT(chain_.predicted(6 * step, map_), pose_near(camera_from_world(6), 1e-9, 1e-9));
  const double length = (world_from_camera(1).translation() - world_from_camera(0).translation()).norm();
  EXPECT_NEAR(*chain_.length_between(0, step, map_), length, 1e-9);
}

/// Points in front of a camera that moves sideways.
class LocalMapTest : public ::testing::Test {
 protected:
  LocalMapTest() {
    Random random(5);
    for (std::int64_t id = 0; id < 60; ++id) {
      const double x = random.uniform(-2.0, 6.0), y = random.uniform(-1.5, 1.5), z = random.uniform(4.0, 9.0);
      points_[3 * id] = {x, y, z};
    }
    options_.window_keyframes = 4;
  }
  static SE3 pose(int k) { return SE3(SO3::exp({0.0, 0.02 * k, 0.0}), {-0.5 * k, 0.0, 0.0}); }
  RayObservations seen_from(const SE3& camera_from_world) const {
    RayObservations rays;
    for (const auto& [id, point] : points_) {
      const Eigen::Vector3d p = camera_from_world * point;
      if (std::abs(p.x()) < 0.8 * p.z()) rays.push_back({id, p.hnormalized()});
    }
    return rays;
  }
  void add(int k, const SE3& off = SE3()) { map_.add_keyframe(k * step, off * pose(k), seen_from(pose(k))); }

  FeaturesOptions options_;
  std::map<std::int64_t, Eigen::Vector3d> points_;
  LocalMap map_{options_, 500.0};
};

TEST_F(LocalMapTest, FindsRaysByTheirIds) {
  const RayObservations rays = seen_from(pose(0));
  for (std::int64_t id = -1; id < 181; ++id) {
    const auto found = std::find_if(rays.begin(), rays.end(), [&](const RayObservation& one) { return one.id == id; });
    const Eigen::Vector2d* ray = find_ray(rays, id);
    ASSERT_EQ(ray != nullptr, found != rays.end()) << id;
    if (ray != nullptr) {
      EXPECT_EQ(*ray, found->ray);
    }
  }
}

TEST_F(LocalMapTest, TriangulatesExactlyWhatTwoKeyframesObserve) {
  add(0);
  EXPECT_EQ(map_.triangulate(), 0) << "no parallax";
  add(1);
  const int triangulated = map_.triangulate();
  EXPECT_EQ(triangulated, static_cast<int>(map_.points().size()));
  EXPECT_GT(triangulated, 20);
  for (const auto& [id, position] : map_.points()) {
    EXPECT_LT((position - points_.at(id)).norm(), 1e-5) << id;
    EXPECT_TRUE(find_ray(map_.keyframes()[0].observations, id) && find_ray(map_.keyframes()[1].observations, id));
  }
  EXPECT_EQ(map_.triangulate(), 0) << "nothing twice";
}

TEST_F(LocalMapTest, WhatLeavesTheWindowIsDroppedExceptForItsPose) {
  for (int k = 0; k < 9; ++k) {
    EXPECT_EQ(map_.window_is_full(), k >= 4) << k;
    add(k);
    map_.triangulate();
    ASSERT_EQ(map_.keyframes().size(), static_cast<std::size_t>(k) + 1);
    for (int i = 0; i <= k; ++i)
      EXPECT_EQ(map_.keyframes()[static_cast<std::size_t>(i)].observations.empty(), i < k - 3) << i;
    for (const auto& [id, position] : map_.points()) {
      bool seen = false;
      for (int i = std::max(0, k - 3); i <= k; ++i)
        seen = seen || find_ray(map_.keyframes()[static_cast<std::size_t>(i)].observations, id) != nullptr;
      EXPECT_TRUE(seen) << id;
    }
  }
  EXPECT_THAT(map_.keyframes()[0].camera_from_world, pose_near(pose(0), 0.0, 0.0));
}

TEST_F(LocalMapTest, ARestartKeepsNoMemoryOfTheWindow) {
  for (int k = 0; k < 9; ++k) {
    add(k);
    if (k % 3 == 2) map_.restart();
  }
  for (const LocalMap::Keyframe& keyframe : map_.keyframes()) EXPECT_EQ(keyframe.observations.capacity(), 0U);
  EXPECT_THAT(map_.keyframes()[8].camera_from_world, pose_near(pose(8), 0.0, 0.0));
}

TEST_F(LocalMapTest, TheWindowHasEveryObservationOfItsPoints) {
  for (int k = 0; k < 6; ++k) {
    add(k);
    map_.triangulate();
  }
  std::vector<std::int64_t> ids;
  const RefinementWindow window = map_.window(ids);
  ASSERT_EQ(window.camera_from_world.size(), 4U);
  EXPECT_EQ(std::vector<int>(window.fixed.begin(), window.fixed.end()), (std::vector<int>{1, 1, 0, 0}));
  ASSERT_EQ(ids.size(), window.points.size());
  std::size_t expected = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(window.points[i], map_.points().at(ids[i]));
    for (std::size_t k = 2; k < 6; ++k) expected += find_ray(map_.keyframes()[k].observations, ids[i]) ? 1 : 0;
  }
  EXPECT_EQ(window.observations.size(), expected);
  for (const auto& seen : window.observations) {
    const auto& rays = map_.keyframes()[static_cast<std::size_t>(seen.camera) + 2].observations;
    EXPECT_EQ(seen.ray, *find_ray(rays, ids[static_cast<std::size_t>(seen.point)]));
  }
}

TEST_F(LocalMapTest, RefinementRecoversPerturbedKeyframes) {
  add(0);
  add(1);
  add(2, SE3::exp((Vector6d() << 0.01, -0.005, 0.01, 0.002, -0.003, 0.001).finished()));
  add(3, SE3::exp((Vector6d() << -0.01, 0.005, 0.015, -0.002, 0.002, 0.002).finished()));
  map_.triangulate();
  for (int k = 0; k < 5; ++k) map_.refine();
  for (int k = 0; k < 4; ++k)
    EXPECT_THAT(map_.keyframes()[static_cast<std::size_t>(k)].camera_from_world, pose_near(pose(k), 2e-3, 5e-4)) << k;
  EXPECT_LT(map_.refine(), 0.05) << "px";
}

TEST_F(LocalMapTest, DropsPointsWithALargeReprojectionError) {
  add(0);
  add(1);
  map_.triangulate();
  const auto before = map_.points();
  RayObservations rays = seen_from(pose(2));
  std::vector<std::int64_t> wrong;
  for (std::size_t i = 0; i < rays.size(); i += 4) {
    if (!before.count(rays[i].id)) continue;
    rays[i].ray.y() += 0.02;  // ten pixels
    wrong.push_back(rays[i].id);
  }
  ASSERT_GT(wrong.size(), 3U);
  map_.add_keyframe(2 * step, pose(2), rays);
  map_.drop_bad_points();
  EXPECT_EQ(map_.points().size(), before.size() - wrong.size());
  for (const std::int64_t id : wrong) EXPECT_EQ(map_.points().count(id), 0U);
}

TEST_F(LocalMapTest, ARestartDropsPointsAndKeepsPoses) {
  for (int k = 0; k < 5; ++k) add(k);
  map_.triangulate();
  EXPECT_TRUE(map_.window_is_full());
  map_.restart();
  EXPECT_TRUE(map_.points().empty());
  EXPECT_EQ(map_.keyframes().size(), 5U);
  EXPECT_FALSE(map_.window_is_full()) << "it starts again";
  add(5);
  EXPECT_EQ(map_.triangulate(), 0) << "earlier observations do not count";
  add(6);
  EXPECT_GT(map_.triangulate(), 20);
}

}  // namespace
}  // namespace rastro
