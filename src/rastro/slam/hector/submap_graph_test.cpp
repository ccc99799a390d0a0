// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/hector/submap_graph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rastro/slam/hector/hector_testing.h"

namespace rastro {
namespace {

using testing::pose_of;
using testing::room_drive;
using testing::WalledDrive;

/// What the matcher makes of a drive: every fourth frame a key scan, the first ones in a finished submap, the others in
/// one that is still made. Between the two its frame slips.
struct MatchedDrive {
  HectorOptions options;
  WalledDrive drive;
  SE2 drift;
  std::size_t first_part = 24, every = 4;

  SE2 local(std::size_t k) const { return k < first_part ? drive.truth(k) : drift * drive.truth(k); }

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

  /// Largest distance of a key scan from where it was taken, metres.
  double worst_m(const SubmapGraph& graph) const {
    double worst = 0.0;
    for (std::size_t i = 0; i < graph.key_scans().size(); ++i)
      worst =
          std::max(worst, (graph.world_from_key_scan(i).translation() - drive.truth(every * i).translation()).norm());
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
    graph.optimize();  // all ties say the same
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

TEST(SubmapGraph, LoopsAreFoundWhereTheScanWasTakenAndTakeTheDriftOut) {
  const MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  const double before = matched.worst_m(graph);
  ASSERT_GT(before, 0.07) << "there must be drift to take out";
  const int closed = graph.look_for_loops(6);
  ASSERT_GT(closed, 0);
  EXPECT_EQ(static_cast<std::size_t>(closed), graph.loops().size());
  EXPECT_NEAR(matched.worst_m(graph), before, 1e-12) << "poses are not touched yet";
  for (const ClosedLoop& loop : graph.loops()) {
    EXPECT_EQ(loop.submap, 0U);
    EXPECT_GE(loop.key_scan, 6U);
    const SE2 truth = matched.local(0).inverse() * matched.drive.truth(4 * loop.key_scan);
    const SE2 submap_from_first = graph.submaps()[0]->local_from_submap().inverse() * matched.local(0);
    const SE2 error = (submap_from_first * truth).inverse() * loop.submap_from_body;
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

TEST(SubmapGraph, NoLoopToASubmapThatIsNotFinishedOrThatMadeTheScan) {
  MatchedDrive matched = drifting();
  matched.first_part = 1000;  // one submap only
  matched.drift = SE2();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph);
  EXPECT_EQ(graph.look_for_loops(0), 0);
  graph.submaps().front()->finish();
  EXPECT_EQ(graph.look_for_loops(0), 0) << "its own scans tell nothing";
  EXPECT_EQ(graph.tie_neighbours(), 0) << "nor do those in its middle";
}

TEST(SubmapGraph, AnotherRoomIsNotTakenForTheFirst) {
  MatchedDrive matched = drifting();
  SubmapGraph graph(matched.options, nullptr);
  graph.add_submap(matched.local(0));
  for (std::size_t k = 0; k <= 20; k += 4) graph.add_key_scan(matched.key_scan(k), MatchedDrive::covariance());
  graph.submaps().front()->finish();
  graph.add_submap(matched.local(24));
  // A long narrow room with pillars, as far as the matcher knows at the same place.
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
  EXPECT_EQ(graph.look_for_loops(6), 0);
}

TEST(SubmapGraph, TheSameForAnyPool) {
  const MatchedDrive matched = drifting();
  TaskPool pool(3);
  SubmapGraph one(matched.options, nullptr), many(matched.options, &pool);
  for (SubmapGraph* graph : {&one, &many}) {
    matched.fill(*graph);
    graph->look_for_loops(6);
    graph->optimize();
    graph->tie_neighbours();
    graph->optimize();
  }
  ASSERT_EQ(one.loops().size(), many.loops().size());
  for (std::size_t i = 0; i < one.key_scans().size(); ++i)
    EXPECT_EQ(one.world_from_key_scan(i).matrix(), many.world_from_key_scan(i).matrix());
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
