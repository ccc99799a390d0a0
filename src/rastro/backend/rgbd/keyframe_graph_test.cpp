// SPDX-License-Identifier: Apache-2.0
#include "rastro/backend/rgbd/keyframe_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "rastro/backend/rgbd/rgbd_testing.h"

namespace rastro {
namespace {

using testing::bare_keyframe;
using testing::edge_of;
using testing::in_submap;
using testing::matrix_near;
using testing::pose_near;
using testing::random_vector;
using Ids = std::vector<std::int64_t>;

RgbdSlamOptions no_candidates() {
  RgbdSlamOptions options;
  options.last_candidates = options.near_candidates = options.graph_candidates = 0;
  options.random_candidates = options.join_candidates = 0;
  return options;
}

void add_keyframe(KeyframeGraph& graph, const SE3& pose, int submap = 0, std::size_t features = 1) {
  graph.add(bare_keyframe(graph.size(), features), in_submap(pose, submap), Matrix6d::Zero());
}

/// `count` keyframes of submap 0 in a chain, half a meter from one to the next.
KeyframeGraph chain(int count, const RgbdSlamOptions& options) {
  KeyframeGraph graph(options, 0);
  for (int k = 0; k < count; ++k) {
    add_keyframe(graph, SE3(SO3(), {0.5 * k, 0.0, 0.0}));
    if (k > 0) graph.add_edge(edge_of(k - 1, k, SE3(SO3(), {0.5, 0.0, 0.0})));
  }
  return graph;
}

/// Random poses, submaps and edges; every seventh keyframe has no features left.
KeyframeGraph random_graph(int count, int submaps, const RgbdSlamOptions& options, std::uint64_t seed) {
  Random random(seed);
  KeyframeGraph graph(options, 0);
  for (int k = 0; k < count; ++k) {
    add_keyframe(graph, SE3::exp(random_vector<Vector6d>(random, 0.6)),
                 static_cast<int>(random.below(static_cast<std::uint32_t>(submaps))), k % 7 == 3 ? 0 : 1);
    if (k > 0 && random.below(5) > 0) {
      const std::int64_t other = random.below(static_cast<std::uint32_t>(k));
      graph.add_edge(random.below(2) > 0 ? edge_of(other, k, SE3()) : edge_of(k, other, SE3()));
    }
  }
  return graph;
}

TEST(KeyframeGraphCandidates, AreDistinctOlderBoundedAndTheSameForASeed) {
  const RgbdSlamOptions options;
  const auto most =
      static_cast<std::size_t>(options.last_candidates + 2 * options.near_candidates + options.graph_candidates +
                               options.random_candidates + options.join_candidates);
  std::set<std::vector<std::int64_t>> drawn;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const KeyframeGraph graph = random_graph(50, 3, options, seed % 8);
    Random random(seed), again(seed);
    const Ids chosen = graph.candidates(graph.size() - 1, random);
    EXPECT_EQ(chosen, graph.candidates(graph.size() - 1, again));
    EXPECT_EQ(std::set<std::int64_t>(chosen.begin(), chosen.end()).size(), chosen.size());
    EXPECT_LE(chosen.size(), most);
    EXPECT_GE(chosen.size(), 7U) << "fifty to choose from";
    for (const std::int64_t id : chosen) EXPECT_TRUE(id >= 0 && id < graph.size() - 1) << id;
    drawn.insert(chosen);
  }
  EXPECT_GT(drawn.size(), 35U) << "another seed draws others";
}

TEST(KeyframeGraphCandidates, TheFirstKeyframesHaveFewOrNone) {
  const KeyframeGraph graph = chain(3, {});
  Random random(1);
  EXPECT_TRUE(graph.candidates(0, random).empty());
  EXPECT_THAT(graph.candidates(1, random), ::testing::UnorderedElementsAre(0));
  EXPECT_THAT(graph.candidates(2, random), ::testing::UnorderedElementsAre(0, 1));
}

TEST(KeyframeGraphCandidates, TheLastComeFirst) {
  RgbdSlamOptions options = no_candidates();
  options.last_candidates = 4;
  Random random(1);
  EXPECT_EQ(chain(20, options).candidates(19, random), (Ids{18, 17, 16, 15}));
}

/// Against the sorted distances of all keyframes: of the latest ones, then of those before.
TEST(KeyframeGraphCandidates, TheNearestOfTheLatestAndOfTheEarlierAreThoseOfBruteForce) {
  RgbdSlamOptions options = no_candidates();
  options.near_candidates = 5;
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const KeyframeGraph graph = random_graph(120, 2, options, seed);
    const std::int64_t id = graph.size() - 1;
    std::vector<std::pair<double, std::int64_t>> latest, earlier;
    for (std::int64_t k = 0; k < id; ++k) {
      const Eigen::Vector3d offset = graph.pose(k).translation() - graph.pose(id).translation();
      const Eigen::AngleAxisd rotation(graph.pose(k).rotation().matrix().transpose() *
                                       graph.pose(id).rotation().matrix());
      const double far = std::max(offset.norm() / options.near_distance_m, rotation.angle() / options.near_angle_rad);
      if (far < 1.0 && graph.submap(k) == graph.submap(id) && k % 7 != 3)
        (k >= id - options.graph_window ? latest : earlier).emplace_back(far, k);
    }
    Ids expected;
    for (auto* part : {&latest, &earlier}) {
      std::sort(part->begin(), part->end());
      for (std::size_t k = 0; k < part->size() && k < 5; ++k) expected.push_back((*part)[k].second);
    }
    Random random(seed);
    EXPECT_EQ(graph.candidates(id, random), expected) << seed;
    found += static_cast<int>(expected.size());
  }
  EXPECT_GT(found, 30) << "there must be something to find";
}

TEST(KeyframeGraphCandidates, TheNearestAreNearerThanTheReach) {
  RgbdSlamOptions options = no_candidates();
  options.near_candidates = 5;
  options.near_distance_m = 1.0;
  Random random(1);
  EXPECT_EQ(chain(8, options).candidates(7, random), Ids{6}) << "0.5 m; the next is exactly as far as the reach";
}

TEST(KeyframeGraphCandidates, OfTheGraphsNeighborhoodThreeEdgesAway) {
  RgbdSlamOptions options = no_candidates();
  options.graph_candidates = 100;
  Random random(1);
  EXPECT_EQ(chain(20, options).candidates(19, random), (Ids{16, 17, 18}));
  KeyframeGraph closed = chain(20, options);
  closed.add_edge(edge_of(19, 5, SE3(), ConstraintKind::loop));
  EXPECT_EQ(closed.candidates(19, random), (Ids{3, 4, 5, 6, 7, 16, 17, 18}));
  options.graph_candidates = 2;
  KeyframeGraph few = chain(20, options);
  std::set<std::int64_t> drawn;
  for (int k = 0; k < 30; ++k) {
    const Ids two = few.candidates(19, random);
    EXPECT_EQ(two.size(), 2U);
    drawn.insert(two.begin(), two.end());
  }
  EXPECT_EQ(drawn, (std::set<std::int64_t>{16, 17, 18})) << "each has its chance";
}

TEST(KeyframeGraphCandidates, RandomChoiceReachesEveryKeyframe) {
  RgbdSlamOptions options = no_candidates();
  options.random_candidates = 3;
  const KeyframeGraph graph = chain(31, options);
  std::vector<int> times(30, 0);
  Random random(7);
  constexpr int draws = 1000;
  for (int k = 0; k < draws; ++k) {
    const Ids three = graph.candidates(30, random);
    ASSERT_EQ(three.size(), 3U);
    for (const std::int64_t id : three) ++times[static_cast<std::size_t>(id)];
  }
  // A hundred each on average, with a standard deviation of about 9.5.
  for (const int count : times) EXPECT_NEAR(count, 100, 45);
}

TEST(KeyframeGraphCandidates, FromOtherSubmapsWhileThereAreAny) {
  RgbdSlamOptions options = no_candidates();
  options.join_candidates = 3;
  const KeyframeGraph one = random_graph(40, 1, options, 3);
  Random random(5);
  EXPECT_TRUE(one.candidates(39, random).empty());
  const KeyframeGraph graph = random_graph(40, 3, options, 3);
  for (int k = 0; k < 20; ++k) {
    const Ids chosen = graph.candidates(39, random);
    EXPECT_EQ(chosen.size(), 3U);
    for (const std::int64_t id : chosen) {
      EXPECT_NE(graph.submap(id), graph.submap(39));
      EXPECT_NE(id % 7, 3) << "has no features to be matched by";
    }
  }
}

TEST(KeyframeGraphCandidates, OfAGivenMapOnlyItsOwn) {
  KeyframeGraph graph(RgbdSlamOptions(), 10);
  for (int k = 0; k < 25; ++k) add_keyframe(graph, SE3(SO3(), {0.1 * k, 0.0, 0.0}));
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Ids chosen = graph.candidates(24, random);
    EXPECT_FALSE(chosen.empty());
    for (const std::int64_t id : chosen) EXPECT_LT(id, 10);
  }
}

/// Against Floyd and Warshall over the whole graph.
TEST(KeyframeGraph, StepsBetweenKeyframesAreThoseOfAllShortestPaths) {
  const KeyframeGraph graph = random_graph(40, 1, {}, 12);
  constexpr int far = 1000;
  std::vector<std::vector<int>> steps(40, std::vector<int>(40, far));
  for (std::size_t k = 0; k < 40; ++k) steps[k][k] = 0;
  for (const Constraint& edge : graph.edges()) {
    const auto from = static_cast<std::size_t>(edge.from), to = static_cast<std::size_t>(edge.to);
    steps[from][to] = steps[to][from] = 1;
  }
  for (std::size_t via = 0; via < 40; ++via)
    for (std::size_t a = 0; a < 40; ++a)
      for (std::size_t b = 0; b < 40; ++b) steps[a][b] = std::min(steps[a][b], steps[a][via] + steps[via][b]);
  for (const int most : {1, 3, 50}) {
    for (std::size_t a = 0; a < 40; ++a)
      for (std::size_t b = 0; b < 40; ++b)
        EXPECT_EQ(graph.steps_between(static_cast<std::int64_t>(a), static_cast<std::int64_t>(b), most),
                  std::min(most, steps[a][b]))
            << a << ' ' << b;
  }
}

/// Two ends of a gap that tracking may have crossed wrongly.
TEST(KeyframeGraph, AnUncertainConstraintConnectsNothing) {
  for (const double sigma_m : {0.5 * uncertain_edge_m, 1.1 * uncertain_edge_m}) {
    const bool uncertain = sigma_m > uncertain_edge_m;
    const RgbdSlamOptions options;
    KeyframeGraph graph(options, 0);
    for (int k = 0; k < 2; ++k) add_keyframe(graph, SE3(), 0);
    Constraint edge{0, 1};
    edge.information = Matrix6d::Identity() / (sigma_m * sigma_m);
    graph.add_edge(edge);
    EXPECT_EQ(graph.steps_between(0, 1, 10), uncertain ? 10 : 1);
    const double length_m = graph.graph_paths_from(0).to(1);
    EXPECT_NEAR(length_m, uncertain ? sigma_m / options.loop_drift_share : 0.0, 1e-9);
  }
}

TEST(KeyframeGraph, MergingTransformsTheLargerNumberIntoTheFrameOfTheSmaller) {
  Random random(3);
  for (const bool forward : {true, false}) {
    KeyframeGraph graph({}, 0);
    std::vector<SE3> before;
    for (int k = 0; k < 9; ++k) {
      before.push_back(SE3::exp(random_vector<Vector6d>(random, 2.0)));
      add_keyframe(graph, before.back(), k < 4 ? 1 : k < 7 ? 3 : 0);
    }
    const SE3 relative = SE3::exp(random_vector<Vector6d>(random, 0.5));
    // From submap 1 to 3 by keyframes 2 and 5, or in the opposite direction.
    const Constraint edge =
        forward ? edge_of(2, 5, relative, ConstraintKind::merge) : edge_of(5, 2, relative, ConstraintKind::merge);
    graph.merge(edge);
    const std::size_t from = forward ? 2 : 5, to = forward ? 5 : 2;
    EXPECT_THAT(graph.pose(static_cast<std::int64_t>(from)).inverse() * graph.pose(static_cast<std::int64_t>(to)),
                pose_near(relative, 1e-9, 1e-9));
    for (std::int64_t k = 0; k < 9; ++k) {
      const auto index = static_cast<std::size_t>(k);
      EXPECT_EQ(graph.submap(k), k < 7 ? 1 : 0) << "the smaller number is kept, a third submap has no part";
      const std::size_t first = k < 4 ? 0 : k < 7 ? 4 : 7;
      EXPECT_THAT(graph.pose(static_cast<std::int64_t>(first)).inverse() * graph.pose(k),
                  pose_near(before[first].inverse() * before[index], 1e-9, 1e-9))
          << "moved as one";
      if (k >= 4 && k < 7) continue;
      EXPECT_THAT(graph.pose(k), pose_near(before[index], 0.0, 1e-12)) << "stays";
    }
    graph.merge(edge_of(0, 6, SE3(), ConstraintKind::merge));
    EXPECT_THAT(graph.pose(static_cast<std::int64_t>(from)).inverse() * graph.pose(static_cast<std::int64_t>(to)),
                pose_near(relative, 1e-9, 1e-9))
        << "of one submap already: nothing to do";
  }
}

/// One loop around a square with 40 keyframes, with drifting odometry and known ground truth.
struct Walk {
  std::vector<SE3> ground_truth;
  KeyframeGraph graph;

  explicit Walk(const RgbdSlamOptions& options, std::int64_t frozen = 0) : graph(options, frozen) {
    Random random(17);
    SE3 estimate;
    for (int k = 0; k < 40; ++k) {
      const SE3 step(SO3::exp({0.0, 0.0, k % 10 == 0 ? M_PI / 2.0 : 0.0}), {0.3, 0.0, 0.0});
      ground_truth.push_back(k == 0 ? SE3() : ground_truth.back() * step);
      Vector6d drift;
      for (int i = 0; i < 6; ++i) drift[i] = (i < 3 ? 0.01 : 0.005) * random.normal() + (i == 5 ? 0.01 : 0.0);
      const SE3 measured = step * SE3::exp(drift);
      if (k > 0) estimate = estimate * measured;
      add_keyframe(graph, k < frozen ? ground_truth.back() : estimate);
      if (k > 0) graph.add_edge(edge_of(k - 1, k, measured, ConstraintKind::odometry, 0.015, 0.015));
    }
  }
  void close(std::int64_t from, std::int64_t to, const SE3& wrong_by = SE3()) {
    const SE3 right =
        ground_truth[static_cast<std::size_t>(from)].inverse() * ground_truth[static_cast<std::size_t>(to)];
    graph.add_edge(edge_of(from, to, right * wrong_by, ConstraintKind::loop, 0.01, 0.01));
  }
  double worst_m() const {
    double worst = 0.0;
    for (std::int64_t k = 0; k < graph.size(); ++k)
      worst = std::max(worst,
                       (graph.pose(k).translation() - ground_truth[static_cast<std::size_t>(k)].translation()).norm());
    return worst;
  }
};

TEST(KeyframeGraph, ALoopReducesTheErrorAgainstGroundTruth) {
  for (const char* loops : {"switchable", "robust"}) {
    RgbdSlamOptions options;
    options.loops = loops;
    options.optimize_iterations = 50;
    Walk walk(options);
    const double before = walk.worst_m();
    ASSERT_GT(before, 0.5) << "there must be drift to take away";
    const PoseGraphResult open = walk.graph.optimize(true);
    EXPECT_NEAR(walk.worst_m(), before, 1e-6) << "a chain fits itself";
    EXPECT_NEAR(open.last_cost, 0.0, 1e-9);
    for (const auto& [from, to] : {std::pair{0, 39}, {1, 38}, {2, 37}}) walk.close(from, to);
    walk.graph.optimize(true);
    EXPECT_LT(walk.worst_m(), 0.35 * before) << loops;
    for (std::size_t e = 39; e < walk.graph.edges().size(); ++e) EXPECT_GT(walk.graph.edges()[e].weight, 0.5) << loops;
    EXPECT_THAT(walk.graph.pose(0), pose_near(SE3(), 0.0, 0.0)) << "the first says where the world is";
  }
}

/// As many iterations as a large graph would take; stages begin at a price at which a wrong loop costs much more.
TEST(KeyframeGraph, InALargeGraphOnlyANewLoopThatIsFarOffIsIntroducedInStages) {
  double cost_of_small = 0.0;
  for (const int iterations : {50, 10000}) {
    RgbdSlamOptions options;
    options.optimize_iterations = iterations;
    Walk walk(options);
    for (const auto& [from, to] : {std::pair{0, 39}, {1, 38}, {2, 37}, {10, 30}}) walk.close(from, to);
    walk.close(5, 25, SE3(SO3::exp({0.0, 0.0, 0.8}), {1.5, -1.0, 0.5}));
    walk.graph.optimize(true);
    for (std::size_t e = 39; e < 42; ++e) EXPECT_GT(walk.graph.edges()[e].weight, 0.5) << "far off, but right";
    ASSERT_LT(walk.graph.edges()[43].weight, 0.05);
    const SE3 seen = walk.graph.pose(3).inverse() * walk.graph.pose(36);
    walk.graph.add_edge(edge_of(3, 36, seen, ConstraintKind::loop, 0.01, 0.01));
    const double cost = walk.graph.optimize(true).first_cost;
    if (iterations == 50) {
      cost_of_small = cost;
    } else {
      EXPECT_LT(cost, 0.5 * cost_of_small) << "all edges had the stages";
    }
  }
}

TEST(KeyframeGraph, AContradictingLoopHasNoWeight) {
  for (const char* loops : {"switchable", "robust"}) {
    RgbdSlamOptions options;
    options.loops = loops;
    options.optimize_iterations = 50;
    Walk with(options), without(options);
    for (Walk* walk : {&with, &without})
      for (const auto& [from, to] : {std::pair{0, 39}, {1, 38}, {2, 37}, {10, 30}}) walk->close(from, to);
    with.close(5, 25, SE3(SO3::exp({0.0, 0.0, 0.8}), {1.5, -1.0, 0.5}));
    with.graph.optimize(true);
    without.graph.optimize(true);
    EXPECT_LT(with.graph.edges().back().weight, 0.05) << loops;
    EXPECT_GT(with.graph.edges()[39].weight, 0.5) << loops;
    EXPECT_LT(with.worst_m(), without.worst_m() + 0.05) << loops;
  }
}

TEST(KeyframeGraph, AWindowMovesOnlyTheLastKeyframesAndAFrozenMapStays) {
  RgbdSlamOptions options;
  options.graph_window = 6;
  Walk walk(options);
  walk.close(0, 39);
  const std::vector<KeyframePose> before = walk.graph.keyframe_poses();
  walk.graph.optimize(false);
  for (std::int64_t k = 0; k < 40; ++k) {
    const double moved =
        (walk.graph.pose(k).translation() - before[static_cast<std::size_t>(k)].world_from_camera.translation()).norm();
    if (k < 34) {
      EXPECT_EQ(moved, 0.0) << k;
    } else {
      EXPECT_GT(moved, 1e-6) << k;
    }
  }
  Walk localized({}, 20);
  localized.close(3, 39);
  localized.graph.optimize(true);
  for (std::size_t k = 0; k < 20; ++k)
    EXPECT_THAT(localized.graph.pose(static_cast<std::int64_t>(k)), pose_near(localized.ground_truth[k], 0.0, 0.0));
  EXPECT_THAT(localized.graph.pose(39), pose_near(localized.ground_truth[39], 0.05, 0.05));
}

TEST(KeyframeGraph, TheFirstKeyframeOfEachSubmapStays) {
  KeyframeGraph graph({}, 0);
  for (int k = 0; k < 6; ++k) add_keyframe(graph, SE3(SO3(), {1.0 * k, 0.0, 0.0}), k < 3 ? 0 : 1);
  for (const int k : {1, 2, 4, 5}) graph.add_edge(edge_of(k - 1, k, SE3(SO3(), {1.5, 0.0, 0.0})));
  graph.optimize(true);
  for (std::int64_t k = 0; k < 6; ++k) {
    const double first = k < 3 ? 0.0 : 3.0;
    EXPECT_NEAR(graph.pose(k).translation().x(), first + 1.5 * static_cast<double>(k % 3), 1e-6) << k;
  }
}

TEST(KeyframeGraph, AKeyframeWithoutFeaturesKeepsItsIdAndIsNoCandidate) {
  RgbdSlamOptions options = no_candidates();
  options.random_candidates = 100;
  KeyframeGraph graph = chain(8, options);
  const auto held = graph.shared_keyframe(3);
  graph.forget_features(3);
  EXPECT_EQ(held->features.size(), 1U) << "whoever holds the old one keeps it";
  EXPECT_EQ(graph.keyframe(3).features.size(), 0U);
  EXPECT_TRUE(graph.keyframe(3).depths.empty());
  EXPECT_EQ(graph.keyframe(3).id, 3);
  EXPECT_EQ(graph.keyframe(3).frame, held->frame);
  EXPECT_EQ(graph.keyframe(3).stamp, held->stamp);
  Random random(1);
  EXPECT_EQ(graph.candidates(7, random), (Ids{0, 1, 2, 4, 5, 6}));
}

TEST(KeyframeGraph, TheMostRedundantHasTheMostNeighborsWithFeatures) {
  RgbdSlamOptions options;
  options.graph_window = 2;
  KeyframeGraph graph = chain(8, options);
  EXPECT_FALSE(graph.most_redundant(3));
  EXPECT_EQ(graph.most_redundant(2), 1) << "the first of equals";
  graph.add_edge(edge_of(1, 2, SE3(), ConstraintKind::proximity));
  EXPECT_FALSE(graph.most_redundant(3)) << "a second edge to the same neighbor says nothing new";
  graph.add_edge(edge_of(5, 2, SE3(), ConstraintKind::proximity));
  EXPECT_EQ(graph.most_redundant(3), 2);
  graph.add_edge(edge_of(5, 0, SE3(), ConstraintKind::proximity));
  EXPECT_EQ(graph.most_redundant(3), 5) << "has four";
  EXPECT_FALSE(graph.most_redundant(5));
  graph.forget_features(5);
  EXPECT_FALSE(graph.most_redundant(3)) << "nor is one without features left a neighbor";
  EXPECT_EQ(graph.most_redundant(2), 1);
  for (const std::int64_t other : {0, 1, 2, 3}) graph.add_edge(edge_of(other, 6, SE3(), ConstraintKind::proximity));
  EXPECT_NE(graph.most_redundant(2), 6) << "the newest are kept";
}

TEST(KeyframeGraph, KeyframesOfAGivenMapAreNotRedundant) {
  RgbdSlamOptions options;
  options.graph_window = 2;
  KeyframeGraph graph(options, 4);
  for (int k = 0; k < 9; ++k) {
    add_keyframe(graph, SE3());
    if (k > 0) graph.add_edge(edge_of(k - 1, k, SE3()));
  }
  EXPECT_EQ(graph.most_redundant(2), 4);
}

TEST(KeyframeGraph, ThePathIsThatOfTheSubmapAndCountsRotations) {
  KeyframeGraph graph({}, 0);
  const SE3 step(SO3::exp({0.0, 0.0, 0.5}), {0.3, 0.0, 0.0});
  SE3 pose;
  for (int k = 0; k < 6; ++k, pose = pose * step) {
    add_keyframe(graph, pose);
    add_keyframe(graph, SE3(SO3(), {100.0 * k, 0.0, 0.0}), 1);
  }
  EXPECT_NEAR(graph.path_between(2, 8), 3 * 0.8, 1e-9);
  EXPECT_EQ(graph.path_between(4, 4), 0.0);
}

TEST(KeyframeGraphTrackedMotion, IsTheProductOfOdometryAndGathersItsErrors) {
  Random random(3);
  KeyframeGraph graph({}, 0);
  std::vector<SE3> steps;
  for (int k = 0; k < 5; ++k) {
    add_keyframe(graph, SE3());
    if (k == 0) continue;
    steps.push_back(SE3::exp(random_vector<Vector6d>(random, 0.4)));
    graph.add_edge(edge_of(k - 1, k, steps.back(), ConstraintKind::odometry, 0.01 * k, 0.02));
    if (k > 1) graph.add_edge(edge_of(k - 2, k, SE3(), ConstraintKind::proximity));
  }
  const auto motion = graph.tracked_motion(1, 4, 10);
  ASSERT_TRUE(motion);
  const SE3 product = steps[1] * steps[2] * steps[3];
  EXPECT_THAT(motion->from_from_to, pose_near(product, 1e-12, 1e-12));
  // Each step's error d moves the product by the adjoint of what follows it.
  Matrix6d expected = Matrix6d::Zero();
  for (int k = 2; k <= 4; ++k) {
    for (int axis = 0; axis < 6; ++axis) {
      const double sigma = axis < 3 ? 0.01 * k : 0.02, step = 1e-6;
      SE3 disturbed;
      for (int j = 2; j <= 4; ++j) {
        disturbed = disturbed * steps[static_cast<std::size_t>(j - 1)];
        if (j == k) disturbed = disturbed * SE3::exp(step * Vector6d::Unit(axis));
      }
      const Vector6d change = (product.inverse() * disturbed).log() / step;
      expected += sigma * sigma * change * change.transpose();
    }
  }
  EXPECT_THAT(motion->covariance, matrix_near(expected, 1e-5 * expected.norm()));
  EXPECT_THAT(graph.tracked_motion(2, 2, 10)->from_from_to, pose_near(SE3(), 0.0, 0.0));
}

TEST(KeyframeGraphTrackedMotion, IsNoneAfterALossOrOverTooManyKeyframes) {
  KeyframeGraph graph({}, 0);
  for (int k = 0; k < 6; ++k) {
    add_keyframe(graph, SE3());
    if (k > 0) graph.add_edge(edge_of(k - 1, k, SE3(), k == 3 ? ConstraintKind::proximity : ConstraintKind::odometry));
  }
  EXPECT_TRUE(graph.tracked_motion(0, 2, 10));
  EXPECT_FALSE(graph.tracked_motion(1, 4, 10)) << "relocalized at 3";
  EXPECT_FALSE(graph.tracked_motion(2, 3, 10));
  EXPECT_TRUE(graph.tracked_motion(3, 5, 2));
  EXPECT_FALSE(graph.tracked_motion(3, 5, 1));
}

/// A ring whose odometry is bent, with few iterations in each optimization.
TEST(KeyframeGraph, OptimizesUntilNothingIsGained) {
  RgbdSlamOptions options = no_candidates();
  options.optimize_iterations = 1;
  constexpr int count = 60;
  const SE3 step(SO3::exp({0.0, 2.0 * M_PI / count, 0.0}), {0.5, 0.0, 0.0});
  const SE3 bent = step * SE3(SO3::exp({0.02, 0.03, -0.02}), {0.02, 0.0, 0.0});
  KeyframeGraph graph(options, 0);
  for (int k = 0; k < count; ++k) {
    add_keyframe(graph, k == 0 ? SE3() : graph.pose(k - 1) * bent);
    if (k > 0) graph.add_edge(edge_of(k - 1, k, bent, ConstraintKind::odometry, 0.1, 0.1));
  }
  graph.add_edge(edge_of(count - 1, 0, step));
  KeyframeGraph once = graph;
  const PoseGraphResult first = once.optimize(true), all = graph.optimize_until_converged();
  EXPECT_FALSE(first.converged);
  EXPECT_EQ(all.first_cost, first.first_cost);
  EXPECT_LT(all.last_cost, 0.9 * first.last_cost);
  EXPECT_GT(graph.optimize(true).last_cost, 0.97 * all.last_cost);
}

/// Against Floyd and Warshall 1962, on random graphs in two parts.
TEST(KeyframeGraph, PathsOverConstraintsAreTheShortest) {
  constexpr int count = 14;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    KeyframeGraph graph(no_candidates(), 0);
    double expected[count][count];
    for (int k = 0; k < count; ++k) {
      add_keyframe(graph, SE3());
      for (int j = 0; j < count; ++j) expected[k][j] = k == j ? 0.0 : std::numeric_limits<double>::infinity();
    }
    for (int e = 0; e < 18; ++e) {
      const int part = e % 2 * count / 2, a = part + static_cast<int>(random.below(count / 2)),
                b = part + static_cast<int>(random.below(count / 2));
      if (a == b) continue;
      const double shift = random.uniform(0.1, 3.0), turn = random.uniform(0.0, 1.0);
      graph.add_edge(edge_of(a, b, SE3(SO3::exp({0.0, turn, 0.0}), {shift, 0.0, 0.0})));
      expected[a][b] = expected[b][a] = std::min(expected[a][b], shift + turn);
    }
    for (int k = 0; k < count; ++k)
      for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) expected[i][j] = std::min(expected[i][j], expected[i][k] + expected[k][j]);
    for (int i = 0; i < count; ++i) {
      GraphPaths paths = graph.graph_paths_from(i);
      for (int j = 0; j < count; ++j) {
        if (std::isinf(expected[i][j]))
          EXPECT_TRUE(std::isinf(paths.to(j)));
        else
          EXPECT_NEAR(paths.to(j), expected[i][j], 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace rastro
