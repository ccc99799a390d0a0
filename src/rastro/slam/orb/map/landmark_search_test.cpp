// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/landmark_search.h"

#include <gtest/gtest.h>

#include "rastro/slam/orb/map/graph_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::add_landmark;
using testing::blank_frame;
using testing::ExactMap;
using testing::Observed;
using testing::PointWorld;
using LandmarkIds = std::vector<std::int64_t>;

TEST(LandmarkSearch, LandmarksAroundAreThoseOfTheKeyframesThatShareEnough) {
  MapGraph graph(testing::small_camera(), CameraKind::mono, 0.0, {});
  for (int k = 0; k < 4; ++k) graph.add_keyframe(blank_frame(k), SE3(), 0, k - 1);
  for (std::uint32_t f = 0; f < 3; ++f) add_landmark(graph, f, {0, 1});  // 0 1 2
  for (std::uint32_t f = 3; f < 5; ++f) add_landmark(graph, f, {0, 2});  // 3 4
  for (std::uint32_t f = 5; f < 7; ++f) add_landmark(graph, f, {2, 3});  // 5 6
  const std::int64_t of_one = add_landmark(graph, 7, {1});               // 7
  const std::int64_t own = add_landmark(graph, 8, {0});                  // 8
  EXPECT_EQ(landmarks_around(graph, 0, 2, 10), (LandmarkIds{0, 1, 2, 3, 4, 5, 6, of_one, own}));
  EXPECT_EQ(landmarks_around(graph, 0, 3, 10), (LandmarkIds{0, 1, 2, 3, 4, of_one, own}));
  EXPECT_EQ(landmarks_around(graph, 0, 2, 1), (LandmarkIds{0, 1, 2, 3, 4, of_one, own}))
      << "who shares most comes first";
  EXPECT_EQ(landmarks_around(graph, 0, 4, 10), (LandmarkIds{0, 1, 2, 3, 4, own}));
  EXPECT_EQ(landmarks_of(graph.keyframe(2)), (LandmarkIds{3, 4, 5, 6}));
  std::vector<std::uint8_t> expected(testing::feature_count, 0);
  for (const std::size_t feature : {3U, 4U, 5U, 6U}) expected[feature] = 1;
  EXPECT_EQ(features_with_landmarks(graph.keyframe(2)), expected);
}

/// Number of landmarks found in an exact frame; none may be wrong.
std::size_t found(const ExactMap& map, const Observed& observed, const Sim3& camera_from_world,
                  const LandmarkSearchOptions& options) {
  const LandmarkIds landmarks = map.graph.landmark_ids();
  const auto matches = search_landmarks(map.graph, landmarks, *observed.frame, camera_from_world, options);
  for (const FeatureMatch& match : matches)
    EXPECT_EQ(landmarks[match.subject], map.landmark_of[observed.seen[match.feature]]);
  return matches.size();
}

TEST(LandmarkSearch, FindsLandmarksInAWindowThatGrowsWithTheLevel) {
  const PointWorld world(200, 5);
  ExactMap map(world, CameraKind::mono, 0.0);
  map.add(0, SE3());
  const Observed observed = world.observe(1, SE3());
  EXPECT_EQ(found(map, observed, Sim3(), {}), 200U);
  // Rotated by this many pixels of the finest level; a rotation about the optical axis changes nothing else.
  const auto aside = [](double px) { return Sim3(1.0, SO3::exp({0.0, px / 500.0, 0.0}), Eigen::Vector3d::Zero()); };
  std::size_t expected = 0;
  for (std::uint32_t i = 0; i < observed.seen.size(); ++i) {
    const Eigen::Vector3d rotated = aside(6.0) * world.points[observed.seen[i]];
    const Eigen::Vector2d off = *world.camera.project(rotated) - observed.frame->pixel(i).cast<double>();
    expected += off.cwiseAbs().maxCoeff() <= 3.0 * std::pow(1.2, observed.frame->level(i)) ? 1U : 0U;
  }
  EXPECT_GT(expected, 20U);
  EXPECT_LT(expected, 180U);
  EXPECT_NEAR(static_cast<double>(found(map, observed, aside(6.0), {.radius_px = 3.0, .limits = {}})),
              static_cast<double>(expected), 2.0);
}

TEST(LandmarkSearch, AnotherUnitChangesNothingUnlessTheRightCameraIsChecked) {
  const PointWorld world(200, 5);
  ExactMap map(world, CameraKind::depth, 0.4);
  map.add(0, SE3());
  const Observed observed = world.observe(1, SE3(), {.baseline = 0.4});
  const Sim3 doubled(2.0, SO3(), Eigen::Vector3d::Zero());
  EXPECT_EQ(found(map, observed, doubled, {}), 200U);
  EXPECT_EQ(found(map, observed, Sim3(), {.radius_px = 2.0, .limits = {}, .check_right_camera = true}), 200U);
  EXPECT_EQ(found(map, observed, doubled, {.radius_px = 2.0, .limits = {}, .check_right_camera = true}), 0U)
      << "half the disparity";
}

TEST(LandmarkSearch, NoSearchFromTooDifferentADirection) {
  const PointWorld world(200, 5);
  ExactMap map(world, CameraKind::mono, 0.0);
  map.add(0, SE3());
  // From the side, about half a radian off at 8 m.
  const SE3 aside = SE3(SO3::exp({0.0, -0.5, 0.0}), Eigen::Vector3d::Zero()) * SE3(SO3(), {4.0, 0.0, 0.0});
  const Observed observed = world.observe(1, aside);
  ASSERT_GT(observed.seen.size(), 60U);
  const std::size_t all = found(map, observed, Sim3(aside), {.limits = {}, .min_view_cosine = 0.3});
  EXPECT_GT(all, observed.seen.size() * 8 / 10);
  EXPECT_EQ(found(map, observed, Sim3(aside), {.limits = {}, .min_view_cosine = 0.999}), 0U);
}

TEST(RotationsBeyondWindows, MoveEveryPixelByMoreThanAWindow) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 500.0, camera.cx = 319.5, camera.cy = 239.5;
  constexpr double window_px = 15.0;
  for (const SO3& rotation : rotations_beyond_windows(window_px, camera)) {
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0, 0), {639, 0}, {320, 240}, {0, 479}, {639, 479}}) {
      const Eigen::Vector2d moved = *camera.project(rotation * camera.unproject(pixel)->homogeneous());
      EXPECT_GT((moved - pixel).lpNorm<Eigen::Infinity>(), 2.0 * window_px);
      EXPECT_LT((moved - pixel).norm(), 6.0 * window_px) << "the camera still sees about the same";
    }
  }
}

}  // namespace
}  // namespace rastro
