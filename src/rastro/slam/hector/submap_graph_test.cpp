// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/submap_graph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/map/graph/planar.h"
#include "rastro/optimize/pose_graph.h"
#include "rastro/slam/hector/final_map.h"
#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

using testing::pose_of;
using testing::room_drive;
using testing::WalledDrive;

/// The matcher's result for a drive: every fourth frame is a key scan, the first ones in a finished submap, the others
/// in an unfinished one. Between the two its frame slips.
struct MatchedDrive {
  HectorOptions options;
  WalledDrive drive;
  SE2 drift;
  std::size_t first_part = 24, every = 4;

  SE2 local(std::size_t k) const { return k < first_part ? drive.ground_truth(k) : drift * drive.ground_truth(k); }

  KeyScan key_scan(std::size_t k) const {
    KeyScan scan;
    scan.stamp = static_cast<TimeNs>(k);
    scan.scan = returns_of(drive.scan(k), options);
    scan.local_from_body = local(k);
    scan.path_m = 0.06 * static_cast<double>(k);
    return scan;
  }

  static Eigen::Matrix3d covariance() { return Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal(); }

  void fill(SubmapGraph& graph) const {
    graph.add_submap(local(0));
    for (std::size_t k = 0; k < drive.world_from_body.size(); k += every) {
      if (k == first_part) {
        graph.submaps().front()->finish();
        graph.add_submap(local(k));
      }
      graph.add_key_scan(key_scan(k), covariance());
    }
  }

  /// Largest position error of a key scan, meters.
  double worst_m(const SubmapGraph& graph) const {
    double worst = 0.0;
    for (std::size_t i = 0; i < graph.key_scans().size(); ++i)
      worst = std::max(
          worst, (graph.world_from_key_scan(i).translation() - drive.ground_truth(every * i).translation()).norm());
    return worst;
  }
};

MatchedDrive drifting() { return {HectorOptions(), room_drive(80), pose_of(0.08, -0.05, -0.02)}; }

TEST(SubmapGraph, WithoutLoopsTheWorldIsTheMatchersFrame) {
  const MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  EXPECT_LT(graph.world_from_local().log().norm(), 1e-12);
  matched.fill(graph);
  ASSERT_EQ(graph.key_scans().size(), 20U);
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = 0; i < graph.key_scans().size(); ++i)
      EXPECT_LT((matched.local(4 * i).inverse() * graph.world_from_key_scan(i)).log().norm(), 1e-6) << i;
    EXPECT_LT(graph.world_from_local().log().norm(), 1e-6);
    graph.optimize();  // all constraints agree
  }
  EXPECT_TRUE(graph.loops().empty());
}

TEST(SubmapGraph, AKeyScanIsPartOfTheUnfinishedSubmapsAlone) {
  const MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  EXPECT_EQ(graph.key_scans_of(0), (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(graph.key_scans_of(1).front(), 6U);
  EXPECT_EQ(graph.key_scans_of(1).back(), 19U);
  EXPECT_EQ(graph.key_scans_of(1).size(), 14U);
}

TEST(SubmapGraph, LoopsAreFoundAtTheTruePoseAndRemoveTheDrift) {
  const MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  const double before = matched.worst_m(graph);
  ASSERT_GT(before, 0.07) << "there must be drift to take out";
  const int closed = graph.search_loops(6);
  ASSERT_GT(closed, 0);
  EXPECT_EQ(static_cast<std::size_t>(closed), graph.loops().size());
  EXPECT_NEAR(matched.worst_m(graph), before, 1e-12) << "poses are not touched yet";
  for (const ClosedLoop& loop : graph.loops()) {
    EXPECT_EQ(loop.submap, 0U);
    EXPECT_GE(loop.key_scan, 6U);
    const SE2 ground_truth = matched.local(0).inverse() * matched.drive.ground_truth(4 * loop.key_scan);
    const SE2 submap_from_first = graph.submaps()[0]->local_from_submap().inverse() * matched.local(0);
    const SE2 error = (submap_from_first * ground_truth).inverse() * loop.submap_from_body;
    EXPECT_LT(error.translation().norm(), 0.03) << loop.key_scan;
    EXPECT_LT(std::abs(error.rotation().angle()), 0.01) << loop.key_scan;
    EXPECT_GT(loop.covariance.diagonal().minCoeff(), 0.0);
  }
  graph.optimize();
  EXPECT_LT(matched.worst_m(graph), 0.5 * before);
  const SE2 last = graph.world_from_local() * matched.local(76);
  EXPECT_LT((last.inverse() * graph.world_from_key_scan(19)).log().norm(), 1e-9)
      << "the matcher goes on from the newest key scan";
}

TEST(SubmapGraph, ConstraintsBetweenKeyScansAreTheMatchedPoses) {
  const MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  ASSERT_GT(graph.search_loops(6), 0);
  graph.optimize();
  const std::vector<Constraint> constraints = graph.constraints();
  const std::size_t steps = graph.key_scans().size() - 1;
  ASSERT_EQ(constraints.size(), steps + graph.loops().size());
  const auto residual = [&](const Constraint& constraint) {
    return edge_residual(constraint, graph.world_from_key_scan(static_cast<std::size_t>(constraint.from)),
                         graph.world_from_key_scan(static_cast<std::size_t>(constraint.to)));
  };
  for (std::size_t k = 0; k < steps; ++k) {
    EXPECT_EQ(constraints[k].kind, ConstraintKind::odometry);
    const SE2 step = matched.local(4 * k).inverse() * matched.local(4 * (k + 1));
    EXPECT_LT((in_plane(constraints[k].rigid()).inverse() * step).log().norm(), 1e-9) << k;
    EXPECT_EQ(constraints[k].to, constraints[k].from + 1);
  }
  for (std::size_t l = 0; l < graph.loops().size(); ++l) {
    const ClosedLoop& loop = graph.loops()[l];
    EXPECT_EQ(constraints[steps + l].kind, ConstraintKind::loop);
    const SE2 submap_from_body =
        graph.world_from_submap(loop.submap).inverse() * graph.world_from_key_scan(loop.key_scan);
    const SE2 rest = loop.submap_from_body.inverse() * submap_from_body;
    const Eigen::Vector3d expected(rest.translation().x(), rest.translation().y(), rest.rotation().angle());
    EXPECT_LT((residual(constraints[steps + l]) - expected).norm(), 1e-9) << l;
  }
}

TEST(SubmapGraph, NoLoopToAnUnfinishedSubmapOrToTheScansOwn) {
  MatchedDrive matched = drifting();
  matched.first_part = 1000;  // one submap only
  matched.drift = SE2();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  EXPECT_EQ(graph.search_loops(0), 0);
  graph.submaps().front()->finish();
  EXPECT_EQ(graph.search_loops(0), 0) << "its own scans tell nothing";
  EXPECT_EQ(graph.constrain_neighbors(), 0) << "nor do those in its middle";
}

TEST(SubmapGraph, ASubmapThatEndedBeforeItsFirstScanClosesNoLoop) {
  const MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  const std::size_t empty = graph.add_submap(SE2());
  graph.submaps()[empty]->finish();
  ASSERT_TRUE(graph.key_scans_of(empty).empty());
  EXPECT_GT(graph.search_loops(6), 0);
  graph.constrain_neighbors();
  for (const ClosedLoop& loop : graph.loops()) EXPECT_NE(loop.submap, empty);
  graph.optimize();
  EXPECT_GT(graph.constraints().size(), 0U);
}

TEST(SubmapGraph, AnotherRoomIsNotMatchedToTheFirst) {
  MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  graph.add_submap(matched.local(0));
  for (std::size_t k = 0; k <= 20; k += 4) graph.add_key_scan(matched.key_scan(k), MatchedDrive::covariance());
  graph.submaps().front()->finish();
  graph.add_submap(matched.local(24));
  // A long narrow room with pillars, which the matcher matches at the same position.
  MatchedDrive other = matched;
  other.drive.walls = {};
  other.drive.walls.add_box(-1.0, -6.0, 1.2, 9.0);
  other.drive.walls.add_box(0.6, 1.0, 0.9, 1.2);
  other.drive.walls.add_box(-0.9, -3.0, -0.3, -2.5);
  for (auto& pose : other.drive.world_from_body) pose = pose_of(0.1, -0.6, 0.3);
  for (std::size_t k = 24; k < 80; k += 4) {
    KeyScan scan = matched.key_scan(k);
    scan.scan = other.key_scan(k).scan;
    graph.add_key_scan(scan, MatchedDrive::covariance());
  }
  EXPECT_EQ(graph.search_loops(6), 0);
}

TEST(SubmapGraph, IsTheSameForAnyPool) {
  const MatchedDrive matched = drifting();
  TaskPool pool(3);
  SubmapGraph one(matched.options, nullptr), many(matched.options, &pool);
  for (SubmapGraph* graph : {&one, &many}) {
    matched.fill(*graph);
    graph->search_loops(6);
    graph->optimize();
    graph->constrain_neighbors();
    graph->optimize();
  }
  ASSERT_EQ(one.loops().size(), many.loops().size());
  for (std::size_t i = 0; i < one.key_scans().size(); ++i)
    EXPECT_EQ(one.world_from_key_scan(i).matrix(), many.world_from_key_scan(i).matrix());
}

/// A graph whose drift a loop closure has removed.
void close_and_optimize(const MatchedDrive& matched, SubmapGraph& graph) {
  matched.fill(graph);
  graph.search_loops(6);
  graph.optimize();
}

double matrix_distance(const SE2& a, const SE2& b) { return (a.matrix() - b.matrix()).norm(); }

TEST(SubmapGraph, ConstraintsLeadFromKeyScanToKeyScan) {
  const MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  close_and_optimize(matched, graph);
  const std::vector<Constraint> constraints = graph.constraints();
  ASSERT_EQ(constraints.size(), 19U + graph.loops().size());
  for (std::size_t k = 0; k < 19; ++k) {
    EXPECT_EQ(constraints[k].kind, ConstraintKind::odometry);
    EXPECT_EQ(constraints[k].from, static_cast<KeyframeId>(k));
    EXPECT_EQ(constraints[k].to, static_cast<KeyframeId>(k) + 1);
    const SE2 expected = matched.local(4 * k).inverse() * matched.local(4 * k + 4);
    EXPECT_LT(matrix_distance(testing::planar(constraints[k].rigid()), expected), 1e-9) << k;
    EXPECT_NEAR(constraints[k].information(0, 0), 1.0 / (0.02 * 0.02) + 1.0 / 9.0, 1e-6);
    EXPECT_NEAR(constraints[k].information(5, 5), 1.0 / (0.005 * 0.005) + 1.0 / (0.3 * 0.3), 1e-6);
  }
  ASSERT_FALSE(graph.loops().empty());
  for (std::size_t i = 0; i < graph.loops().size(); ++i) {
    const ClosedLoop& loop = graph.loops()[i];
    const Constraint& constraint = constraints[19 + i];
    EXPECT_EQ(constraint.kind, ConstraintKind::loop);
    EXPECT_EQ(constraint.from, 0) << "the first key scan of its submap";
    EXPECT_EQ(constraint.to, static_cast<KeyframeId>(loop.key_scan));
    const SE2 expected =
        graph.world_from_key_scan(0).inverse() * graph.world_from_submap(loop.submap) * loop.submap_from_body;
    EXPECT_LT(matrix_distance(testing::planar(constraint.rigid()), expected), 1e-9) << i;
  }
}

TEST(SubmapGraph, OnlyEveryFewKeyScansAreComparedAndARepeatedLoopReplacesTheOld) {
  MatchedDrive matched = drifting();
  matched.options.loop_every = 3, matched.options.constrain_every = 4;
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  const int closed = graph.search_loops(7);
  ASSERT_GT(closed, 0);
  for (const ClosedLoop& loop : graph.loops()) {
    EXPECT_EQ(loop.key_scan % 3, 0U);
    EXPECT_GE(loop.key_scan, 9U) << "not those before the first one asked for";
  }
  EXPECT_EQ(graph.search_loops(7), closed);
  EXPECT_EQ(graph.loops().size(), static_cast<std::size_t>(closed)) << "each pair once";
  std::size_t before = graph.loops().size();
  graph.optimize();
  ASSERT_GT(graph.constrain_neighbors(), 0);
  for (const ClosedLoop& loop : graph.loops())
    EXPECT_TRUE(loop.key_scan % 3 == 0 || loop.key_scan % 4 == 0) << loop.key_scan;
  EXPECT_GT(graph.loops().size(), before);
}

TEST(SubmapGraph, ALoopNeedsTheMinimumScore) {
  MatchedDrive matched = drifting();
  matched.options.loop_min_score = 1.01;
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  EXPECT_EQ(graph.search_loops(6), 0);
}

TEST(ScanPoses, AScanBetweenTwoKeyScansIsMovedByBoth) {
  const MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  close_and_optimize(matched, graph);
  const std::size_t key = 8;  // of frame 32; the next one is of frame 36
  const auto by = [&](std::size_t k, const SE2& local) {
    return graph.world_from_key_scan(k) * graph.key_scans()[k].local_from_body.inverse() * local;
  };
  std::vector<PosedScan> scans(6);
  const TimeNs stamps[] = {31, 32, 33, 35, 36, 40};
  for (std::size_t i = 0; i < 6; ++i) {
    scans[i].stamp = stamps[i];
    scans[i].key_scan = key;
    scans[i].local_from_body = matched.local(33);
  }
  const std::vector<StampedPlanarPose> poses = scan_poses(scans, graph);
  ASSERT_EQ(poses.size(), 6U);
  const SE2 last = by(key, matched.local(33)), next = by(key + 1, matched.local(33));
  EXPECT_GT(matrix_distance(last, next), 1e-6) << "or there is nothing to share";
  const double shares[] = {0.0, 0.0, 0.25, 0.75, 1.0, 1.0};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(poses[i].stamp, stamps[i]);
    EXPECT_LT(matrix_distance(poses[i].pose, interpolate(last, next, shares[i])), 1e-12) << i;
  }
  scans.resize(1);
  scans[0].key_scan = 19;
  scans[0].stamp = 79;
  EXPECT_LT(matrix_distance(scan_poses(scans, graph)[0].pose, by(19, matched.local(33))), 1e-12) << "no next one";
  EXPECT_TRUE(scan_poses(scans, SubmapGraph(matched.options, nullptr)).empty());
}

TEST(ReturnsOf, BothEndsOfTheRangeAreReturns) {
  HectorOptions options;
  options.min_range_m = 1.0, options.max_range_m = 2.0;
  LaserScan scan;
  scan.angle_step = 0.1;
  scan.max_range = 10.0;
  scan.ranges = {0.99F, 1.0F, 1.5F, 2.0F, 2.01F};
  EXPECT_EQ(returns_of(scan, options).points.size(), 3U);
}

TEST(ReturnsOf, AreInTheBodyFrameWithinTheRange) {
  HectorOptions options;
  LaserScan scan;
  scan.first_angle = 0.0;
  scan.angle_step = M_PI / 2.0;
  scan.min_range = 0.1;
  scan.max_range = 10.0;
  scan.body_from_laser = pose_of(0.5, 0.2, M_PI / 2.0);
  scan.ranges = {1.0F, 2.0F, 50.0F, std::nanf("")};
  const ScanPoints returns = returns_of(scan, options);
  EXPECT_LT((returns.sensor - Eigen::Vector2d(0.5, 0.2)).norm(), 1e-12);
  ASSERT_EQ(returns.points.size(), 2U);
  EXPECT_LT((returns.points[0] - Eigen::Vector2d(0.5, 1.2)).norm(), 1e-6);
  EXPECT_LT((returns.points[1] - Eigen::Vector2d(-1.5, 0.2)).norm(), 1e-6);
}

}  // namespace
}  // namespace rastro
