// SPDX-License-Identifier: Apache-2.0
// How far loops are searched for, how uncertain constraints are, and what is freed to save memory.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "rastro/map/graph/planar.h"
#include "rastro/slam/hector/hector_testing.h"
#include "rastro/slam/hector/submap_graph.h"

namespace rastro {
namespace {

using testing::pose_of;
using testing::room_drive;
using testing::WalledDrive;

/// A drive through a room whose every fourth frame is a key scan, four of them in a submap. From `slip_from` on the
/// matcher's frame is off by `slip`.
struct ShortSubmaps {
  HectorOptions options;
  WalledDrive drive = room_drive(80);
  SE2 slip;
  std::size_t slip_from = 1000;
  std::optional<Eigen::Vector2d> unseen_direction = std::nullopt;
  Eigen::Matrix3d gap_covariance = Eigen::Matrix3d::Zero();  ///< Of the step to that key scan.

  SE2 local(std::size_t key) const {
    return key < slip_from ? drive.ground_truth(4 * key) : slip * drive.ground_truth(4 * key);
  }
  void add(SubmapGraph& graph, std::size_t key) const {
    KeyScan scan{0, static_cast<TimeNs>(key), returns_of(drive.scan(4 * key), options), local(key), 0.24 * key, {}};
    scan.unseen_direction = unseen_direction;
    if (key == slip_from) scan.gap_covariance = gap_covariance;
    graph.add_key_scan(scan, Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal());
  }
  /// The last submap stays open.
  void fill(SubmapGraph& graph, std::size_t keys) const {
    for (std::size_t key = 0; key < keys; ++key) {
      if (key % 4 == 0) {
        if (key > 0) graph.submaps().back()->finish();
        graph.add_submap(local(key));
      }
      add(graph, key);
    }
  }
};

std::vector<std::size_t> released_of(SubmapGraph& graph) {
  std::vector<std::size_t> released;
  for (std::size_t s = 0; s < graph.submaps().size(); ++s)
    if (graph.submaps()[s]->released()) released.push_back(s);
  return released;
}

TEST(SubmapGraph, FreesEverySecondSubmapThenPointsThenTheOldestSubmaps) {
  const ShortSubmaps matched;
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph, 20);
  const std::vector<Eigen::Vector2d> points = graph.key_scans()[3].scan.points;
  ASSERT_EQ(points.size(), 360U);
  using Released = std::vector<std::size_t>;
  struct Step {
    std::string what;
    Released released;
    std::size_t points;
  };
  const Step steps[] = {{"others overlap", {1}, 360}, {"others overlap", {1, 3}, 360}, {"second point", {1, 3}, 180},
                        {"second point", {1, 3}, 90}, {"second point", {1, 3}, 45},    {"oldest", {0, 1, 3}, 45},
                        {"oldest", {0, 1, 2, 3}, 45}};
  for (const Step& step : steps) {
    const std::size_t before = graph.bytes();
    EXPECT_NE(graph.give_up_redundant().find(step.what), std::string::npos) << step.what;
    EXPECT_EQ(released_of(graph), step.released) << step.what;
    EXPECT_LT(graph.bytes(), before);
    const std::vector<Eigen::Vector2d>& left = graph.key_scans()[3].scan.points;
    ASSERT_EQ(left.size(), step.points);
    for (std::size_t i = 0; i < left.size(); ++i) EXPECT_EQ(left[i], points[i * (360 / step.points)]);
  }
  const std::size_t least = graph.bytes();
  EXPECT_EQ(graph.give_up_redundant(), "") << "the open submap stays";
  EXPECT_EQ(graph.bytes(), least);
}

/// A bare corridor, and a pillar that comes into view where the first submap knows nothing. Without odometry a doubtful
/// place along it is better than none.
TEST(SubmapGraph, ALoopSaysNothingAlongWhatItsSubmapDoesNotShow) {
  WalledDrive drive;
  drive.walls.add({-40.0, -1.0}, {40.0, -1.0});
  drive.walls.add({-40.0, 1.0}, {40.0, 1.0});
  drive.walls.add_box(11.0, 0.3, 11.5, 1.0);
  drive.reach_m = 6.0;
  drive.world_from_body = {pose_of(0.0, 0.0, 0.0)};
  drive.go(pose_of(0.2, 0.0, 0.0), 30);
  const std::size_t keys = drive.world_from_body.size();
  HectorOptions options;
  options.loop_every = 1;
  for (const bool assumed : {false, true}) {
    SubmapGraph graph(options, nullptr);
    for (std::size_t key = 0; key < keys; ++key) {
      if (key == 10) graph.submaps().back()->finish();
      if (key == 0 || key == 10) graph.add_submap(drive.ground_truth(key));
      KeyScan scan{0, static_cast<TimeNs>(key), returns_of(drive.scan(key), options), drive.ground_truth(key)};
      scan.path_m = 0.2 * static_cast<double>(key);
      scan.assumed_motion = assumed;
      graph.add_key_scan(scan, Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal());
    }
    ASSERT_GT(graph.search_loops(keys - 4), 0);
    for (const ClosedLoop& loop : graph.loops()) {
      EXPECT_EQ(std::sqrt(loop.covariance(0, 0)) > 2.0, !assumed) << loop.key_scan;
      EXPECT_LT(std::sqrt(loop.covariance(1, 1)), 0.1) << loop.key_scan;
    }
  }
}

TEST(SubmapGraph, ScansOfFewPointsAreNotThinned) {
  for (const int beams : {79, 80}) {
    ShortSubmaps matched;
    matched.drive.beams = beams;
    SubmapGraph graph(matched.options, nullptr);
    matched.fill(graph, 2);
    const bool thins = graph.give_up_redundant().find("second point") != std::string::npos;
    EXPECT_EQ(thins, beams == 80) << beams;
    EXPECT_EQ(graph.key_scans()[0].scan.points.size(), beams == 80 ? 40U : 79U);
  }
}

TEST(SubmapGraph, ItsBytesAreThoseOfItsParts) {
  const ShortSubmaps matched;
  SubmapGraph graph(matched.options, nullptr);
  EXPECT_EQ(graph.bytes(), 0U);
  matched.fill(graph, 9);
  // A key scan has a constraint to its submap and to the one before it.
  std::size_t expected = 17 * sizeof(Constraint) + 12 * (sizeof(SE2) + sizeof(std::size_t)) +
                         9 * (sizeof(KeyScan) + 360 * sizeof(Eigen::Vector2d));
  for (const auto& submap : graph.submaps()) expected += submap->bytes();
  EXPECT_EQ(graph.bytes(), expected);
}

TEST(SubmapGraph, AReleasedSubmapHasNoLoops) {
  ShortSubmaps matched;
  matched.options.loop_every = 1;
  for (const bool released : {false, true}) {
    SubmapGraph graph(matched.options, nullptr);
    matched.fill(graph, 8);
    if (released) graph.submaps().front()->release();
    EXPECT_EQ(graph.search_loops(4) > 0, !released);
  }
}

/// Loops of the key scans from 12 on, whose frame is 1.2 m off, with submaps before that.
std::size_t loops_after_a_slip(const HectorOptions& options, const Eigen::Vector3d& gap_sigma = {0.0, 0.0, 0.0}) {
  ShortSubmaps matched;
  matched.options = options;
  matched.slip = pose_of(1.2, 0.0, 0.0);
  matched.slip_from = 12;
  matched.gap_covariance = gap_sigma.cwiseAbs2().asDiagonal();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph, 20);
  graph.search_loops(12);
  return static_cast<std::size_t>(std::count_if(graph.loops().begin(), graph.loops().end(),
                                                [](const ClosedLoop& loop) { return loop.submap < 3; }));
}

TEST(SubmapGraph, TheSearchReachesFartherTheLongerThePathSinceTheSubmap) {
  HectorOptions options;
  options.loop_every = 1;
  options.loop_agreement_m = 2.0;
  options.loop_min_score = 0.8;
  options.loop_drift_share = 0.0;
  EXPECT_EQ(loops_after_a_slip(options), 0U) << "0.4 m are too near";
  options.loop_drift_share = 0.5;  // of up to 4 m
  EXPECT_GT(loops_after_a_slip(options), 0U);
  options.loop_max_reach_m = 0.5;
  EXPECT_EQ(loops_after_a_slip(options), 0U) << "the limit counts";
}

TEST(SubmapGraph, TheSearchReachesAsFarAsMissingScansLeaveThePoseOpen) {
  HectorOptions options;
  options.loop_every = 1;
  options.loop_agreement_m = 2.0;
  options.loop_min_score = 0.8;
  options.loop_drift_share = 0.0;
  EXPECT_EQ(loops_after_a_slip(options, {0.1, 0.1, 0.0}), 0U) << "0.4 m and three times 0.1 m are too near";
  EXPECT_GT(loops_after_a_slip(options, {0.4, 0.1, 0.0}), 0U);
  EXPECT_GT(loops_after_a_slip(options, {0.0, 0.0, 0.3}), 0U) << "a wrong heading leads away";
}

/// They would fit best where they were, which is not where the others are.
TEST(SubmapGraph, ScansOfBeforeMissingOnesDoNotHoldThoseAfterThem) {
  ShortSubmaps matched;
  matched.options.loop_every = 1;
  matched.slip = pose_of(0.3, 0.0, 0.0);
  matched.slip_from = 12;
  matched.gap_covariance = Eigen::Vector3d(0.01, 0.01, 1e-4).asDiagonal();
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph, 13);
  ASSERT_GT(graph.search_loops(12), 0);
  for (const ClosedLoop& loop : graph.loops()) {
    ASSERT_EQ(loop.key_scan, 12U);
    const SE2 expected =
        graph.submaps()[loop.submap]->local_from_submap().inverse() * matched.drive.ground_truth(4 * 12);
    EXPECT_LT((loop.submap_from_body.translation() - expected.translation()).norm(), 0.05) << loop.submap;
  }
}

TEST(SubmapGraph, MissingScansMakeTheStepOverThemUncertainInTheirOwnDirections) {
  ShortSubmaps matched;
  matched.slip_from = 12;
  matched.gap_covariance = Eigen::Vector3d(0.04, 0.0001, 0.001).asDiagonal();
  matched.gap_covariance(0, 2) = matched.gap_covariance(2, 0) = 0.002;
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph, 16);
  Eigen::Matrix3d last_from_local = Eigen::Matrix3d::Identity();
  last_from_local.topLeftCorner<2, 2>() = matched.local(11).rotation().matrix().transpose();
  ASSERT_GT(std::abs(last_from_local(0, 1)), 0.3);
  Eigen::Matrix3d covariance = last_from_local * matched.gap_covariance * last_from_local.transpose();
  covariance.diagonal() += Eigen::Vector3d(4e-4, 4e-4, 2.5e-5);
  Eigen::Matrix3d expected = covariance.inverse();
  expected.diagonal() += Eigen::Vector3d(1.0 / 9.0, 1.0 / 9.0, 1.0 / 0.09);
  const Constraint step = graph.constraints()[11];
  ASSERT_EQ(step.to, 12);
  const Constraint same =
      planar_constraint(11, 12, matched.local(11).inverse() * matched.local(12), expected, step.kind);
  EXPECT_LT((step.information - same.information).norm(), 1e-6 * expected.norm());
}

TEST(SubmapGraph, OnlySubmapsNearTheKeyScanAreSearched) {
  ShortSubmaps matched;
  matched.options.loop_every = 1;
  matched.options.loop_drift_share = 0.0;
  matched.options.loop_reach_m = 0.1;
  for (const double near_m : {0.3, 4.0}) {
    matched.options.loop_near_m = near_m;
    SubmapGraph graph(matched.options, nullptr);
    matched.fill(graph, 20);
    ASSERT_GT(graph.search_loops(4), 0);
    double farthest = 0.0;
    for (const ClosedLoop& loop : graph.loops()) {
      double nearest = 1e9;
      for (const std::size_t key : graph.key_scans_of(loop.submap))
        nearest =
            std::min(nearest, (matched.local(key).translation() - matched.local(loop.key_scan).translation()).norm());
      EXPECT_LT(nearest, near_m + 0.1);
      farthest = std::max(farthest, nearest);
    }
    EXPECT_EQ(farthest > 0.4, near_m > 1.0);
  }
}

/// Along a direction that the scans do not constrain, a step has the error of wheel odometry and a loop none of use.
TEST(SubmapGraph, AnUnobservableDirectionMakesConstraintsUncertainAlongIt) {
  ShortSubmaps matched;
  matched.options.loop_every = 1;
  matched.unseen_direction = Eigen::Vector2d(0.6, 0.8);
  SubmapGraph graph(matched.options, nullptr);
  matched.fill(graph, 8);
  const double length = (matched.local(4).translation() - matched.local(3).translation()).norm();
  Eigen::Matrix3d covariance = Eigen::Vector3d(4e-4, 4e-4, 2.5e-5).asDiagonal();
  const Eigen::Vector2d along = 0.3 * length * *matched.unseen_direction;
  covariance.topLeftCorner<2, 2>() += along * along.transpose();
  Eigen::Matrix3d expected = covariance.inverse();
  expected.diagonal() += Eigen::Vector3d(1.0 / 9.0, 1.0 / 9.0, 1.0 / 0.09);
  const Constraint step = graph.constraints()[3];
  ASSERT_EQ(step.to, 4);
  const Constraint same = planar_constraint(3, 4, matched.local(3).inverse() * matched.local(4), expected, step.kind);
  EXPECT_LT((step.information - same.information).norm(), 1e-6 * expected.norm());
  ASSERT_GT(graph.search_loops(4), 0);
  for (const ClosedLoop& loop : graph.loops()) {
    const Eigen::Vector2d unseen = loop.submap_from_body.rotation() * *matched.unseen_direction;
    const Eigen::Vector2d across(-unseen.y(), unseen.x());
    const Eigen::Matrix2d position = loop.covariance.topLeftCorner<2, 2>();
    EXPECT_NEAR(unseen.dot(position * unseen), 9.0, 0.1);
    EXPECT_LT(across.dot(position * across), 0.1);
  }
}

}  // namespace
}  // namespace rastro
