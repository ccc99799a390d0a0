// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/local_mapping/bundle_problem.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/local_mapping/mapping_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::mapping_pose;
using testing::PointWorld;
using testing::pose_near;

/// Four keyframes; the last one observes only the second half of the points.
struct BundleBench {
  explicit BundleBench(CameraKind sensor) : map(world, sensor, sensor == CameraKind::mono ? 0.0 : 0.1) {
    for (int id = 0; id < 3; ++id) map.add(id, mapping_pose(id), {.to = 100});
    map.add(3, mapping_pose(3), {.from = 100});
  }
  /// Moves a landmark's feature in keyframe 2 by this many standard deviations.
  void move_feature(BundleProblem& problem, std::size_t landmark, double sigmas) {
    for (std::size_t i = 0; i < problem.seen.size(); ++i) {
      if (problem.seen[i] == BundleProblem::Seen{2, map.landmark_of[landmark]})
        problem.bundle.observations[i].ray.y() += sigmas * problem.bundle.observations[i].sigma;
    }
  }

  PointWorld world{200, 11};
  ExactMap map;
};

TEST(BundleProblem, HasTheLandmarksOfTheFreeKeyframesAndAllTheirObservations) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    BundleBench bench(sensor);
    const BundleProblem problem = bundle_problem(bench.map.graph, {2}, {3, 0}, 1.5);
    EXPECT_EQ(problem.keyframes, (std::vector<std::int64_t>{2, 3, 0}));
    EXPECT_EQ(problem.bundle.fixed, (std::vector<std::uint8_t>{0, 1, 1}));
    EXPECT_EQ(problem.bundle.baseline, bench.map.graph.baseline());
    EXPECT_THAT(problem.bundle.camera_from_world[1], pose_near(mapping_pose(3), 0.0, 0.0));
    ASSERT_EQ(problem.landmarks.size(), 100U) << "not those that only the fixed see";
    EXPECT_TRUE(std::is_sorted(problem.landmarks.begin(), problem.landmarks.end()));
    ASSERT_EQ(problem.seen.size(), 200U) << "keyframe 1 is of neither list";
    ASSERT_EQ(problem.bundle.observations.size(), 200U);
    for (std::size_t i = 0; i < problem.seen.size(); ++i) {
      const auto& [keyframe, landmark] = problem.seen[i];
      const BundleObservation& o = problem.bundle.observations[i];
      EXPECT_EQ(problem.keyframes[o.camera], keyframe);
      EXPECT_EQ(problem.landmarks[o.point], landmark);
      const Eigen::Vector3d p = mapping_pose(static_cast<int>(keyframe)) * problem.bundle.points[o.point];
      EXPECT_LT((p.head<2>() / p.z() - o.ray).norm(), 1e-5);
      const auto feature = static_cast<std::size_t>(bench.map.graph.feature_of(keyframe, landmark));
      EXPECT_DOUBLE_EQ(o.sigma, 1.5 * std::pow(1.2, bench.map.graph.keyframe(keyframe).frame->level(feature)) / 500.0);
      EXPECT_EQ(std::isfinite(o.right_x), sensor == CameraKind::depth);
    }
  }
}

TEST(BundleProblem, ObservationsBeyondChiSquareAreRemoved) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    BundleBench bench(sensor);
    const double limit = std::sqrt(sensor == CameraKind::mono ? 5.991 : 7.815);
    // The cameras are fixed and the other observations hold the points: errors keep their size.
    BundleProblem problem = bundle_problem(bench.map.graph, {0, 1, 2}, {}, 1.0);
    bench.move_feature(problem, 7, 100.0);
    bench.move_feature(problem, 8, 0.5 * limit);
    std::fill(problem.bundle.fixed.begin(), problem.bundle.fixed.end(), std::uint8_t{1});
    const std::size_t before = problem.seen.size();
    adjust_bundle_problem(problem, 10, {}, nullptr);
    EXPECT_EQ(problem.seen.size(), before - problem.outliers.size());
    EXPECT_EQ(problem.bundle.observations.size(), problem.seen.size());
    ASSERT_FALSE(problem.outliers.empty());
    for (const auto& [keyframe, landmark] : problem.outliers) EXPECT_EQ(landmark, bench.map.landmark_of[7]);
  }
}

TEST(BundleProblem, ASingleObservationIsJudgedByTheLimitOfItsKind) {
  // The point cannot follow: all other observations hold it, so the iterations do not reduce the error.
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    BundleBench bench(sensor);
    const double limit = std::sqrt(sensor == CameraKind::mono ? 5.991 : 7.815);
    for (const double share : {0.97, 1.03}) {
      BundleProblem problem = bundle_problem(bench.map.graph, {0, 1, 2}, {}, 1.0);
      bench.move_feature(problem, 7, share * limit);
      BundleProblem still = problem;
      adjust_bundle_problem(still, 0, {}, nullptr);
      EXPECT_EQ(still.outliers.size(), share > 1.0 ? 1U : 0U) << share;
    }
  }
}

TEST(BundleProblem, OnceStoppedNothingBecomesAnOutlier) {
  BundleBench bench(CameraKind::mono);
  BundleProblem problem = bundle_problem(bench.map.graph, {1, 2}, {0}, 1.0);
  bench.move_feature(problem, 7, 100.0);
  adjust_bundle_problem(
      problem, 10, [] { return true; }, nullptr);
  EXPECT_TRUE(problem.outliers.empty());
  EXPECT_EQ(problem.seen.size(), 300U);
}

TEST(BundleProblem, AdjustsToGroundTruth) {
  BundleBench bench(CameraKind::depth);
  MapGraph& graph = bench.map.graph;
  Random random(3);
  for (const int id : {1, 2})
    graph.keyframe(id).camera_from_world = SE3::exp(testing::random_vector<Vector6d>(random, 0.01)) * mapping_pose(id);
  BundleProblem problem = bundle_problem(graph, {1, 2}, {0}, 1.0);
  adjust_bundle_problem(problem, 20, {}, nullptr);
  EXPECT_THAT(problem.bundle.camera_from_world[0], pose_near(mapping_pose(1), 1e-3, 1e-4));
  EXPECT_THAT(problem.bundle.camera_from_world[1], pose_near(mapping_pose(2), 1e-3, 1e-4));
  EXPECT_THAT(problem.bundle.camera_from_world[2], pose_near(mapping_pose(0), 0.0, 0.0));
}

TEST(BundleProblem, OneIterationRunsBeforeOutliersAreRemoved) {
  BundleBench bench(CameraKind::depth);
  MapGraph& graph = bench.map.graph;
  graph.keyframe(2).camera_from_world = SE3(SO3::exp({0.01, -0.01, 0.005}), {0.02, 0.01, 0.0}) * mapping_pose(2);
  BundleProblem problem = bundle_problem(graph, {2}, {0, 1}, 1.0);
  BundleProblem untouched = problem;
  adjust_bundle_problem(problem, 1, {}, nullptr);
  EXPECT_TRUE(problem.outliers.empty());
  adjust_bundle_problem(untouched, 0, {}, nullptr);
  EXPECT_GT(untouched.outliers.size(), 50U);
}

TEST(BundleProblem, LandmarksWithTooFewObservationsGoWithTheirOutliers) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    BundleBench bench(sensor);
    MapGraph& graph = bench.map.graph;
    BundleProblem problem = bundle_problem(graph, {0, 1, 2}, {}, 1.0);
    const std::int64_t two_left = bench.map.landmark_of[1], one_left = bench.map.landmark_of[2],
                       none_left = bench.map.landmark_of[3], gone = bench.map.landmark_of[4];
    problem.outliers = {{0, two_left},  {0, one_left},  {1, one_left}, {0, none_left},
                        {1, none_left}, {2, none_left}, {1, gone},     {9, two_left}};
    graph.remove_landmark(gone);
    const std::size_t before = graph.landmark_count();
    graph.landmark(two_left).direction.setZero();
    drop_outliers(graph, problem);
    EXPECT_TRUE(graph.has_landmark(two_left));
    EXPECT_EQ(graph.feature_of(0, two_left), -1);
    EXPECT_GE(graph.feature_of(1, two_left), 0);
    EXPECT_NEAR(graph.landmark(two_left).direction.norm(), 1.0, 1e-12) << "described anew";
    EXPECT_EQ(graph.has_landmark(one_left), sensor == CameraKind::depth);
    EXPECT_FALSE(graph.has_landmark(none_left));
    EXPECT_EQ(graph.landmark_count(), before - (sensor == CameraKind::depth ? 1 : 2));
  }
}

}  // namespace
}  // namespace rastro
