// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/loop_closing/loop_closing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "rastro/backend/acceptance.h"
#include "rastro/math/alignment.h"
#include "rastro/slam/orb/loop_closing/global_bundle_adjustment.h"
#include "rastro/slam/orb/loop_closing/loop_correction.h"
#include "rastro/slam/orb/loop_closing/place_testing.h"
#include "rastro/slam/orb/relocalization/frame_relocalizer.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::DriftingMapper;
using testing::RoundWorld;

constexpr double step = 2.0 * M_PI / 60.0;

/// Map and loop_closing over one world.
struct Bench {
  explicit Bench(CameraKind sensor, const OrbSlamOptions& settings = {})
      : options(settings),
        graph(world.camera, sensor, sensor == CameraKind::mono ? 0.0 : 0.1, OrbOptions{}),
        database(graph, world.vocabulary()),
        loop_closing(options, graph, database),
        mapper(world, graph, sensor == CameraKind::mono ? 0.004 : 0.006, sensor == CameraKind::mono ? 1.004 : 1.0) {}

  /// Root mean square of the keyframes' position errors after alignment; NaN where that is undefined.
  double error() const { return error(mapper); }
  double error(const DriftingMapper& made) const {
    std::vector<Eigen::Vector3d> ground_truth, estimate;
    for (const std::int64_t id : graph.keyframe_ids()) {
      ground_truth.push_back(made.centers[static_cast<std::size_t>(id)]);
      estimate.push_back(graph.keyframe(id).camera_from_world.inverse().translation());
    }
    const bool mono = graph.sensor() == CameraKind::mono;
    const auto aligned = align_points(ground_truth, estimate, mono ? AlignmentKind::similarity : AlignmentKind::rigid);
    // Any two keyframes align exactly with any other two: NaN, which fails every limit.
    return aligned && aligned->unique ? aligned->rmse : std::numeric_limits<double>::quiet_NaN();
  }

  OrbSlamOptions options;
  RoundWorld world{1};
  MapGraph graph;
  KeyframeDatabase database;
  LoopClosing loop_closing;
  DriftingMapper mapper;
};

/// Every list of the map is consistent with every other.
void expect_sound(const MapGraph& graph) {
  for (const std::int64_t id : graph.landmark_ids()) {
    const MapLandmark& landmark = graph.landmark(id);
    EXPECT_GE(landmark.observations.size(), 1U);
    EXPECT_TRUE(landmark.position.allFinite());
    for (const LandmarkObservation& seen : landmark.observations)
      ASSERT_EQ(graph.keyframe(seen.keyframe).landmarks[seen.feature], id);
  }
  int roots = 0;
  for (const std::int64_t id : graph.keyframe_ids()) {
    const MapKeyframe& keyframe = graph.keyframe(id);
    roots += keyframe.parent < 0;
    for (std::size_t i = 0; i < keyframe.landmarks.size(); ++i) {
      const std::int64_t landmark = keyframe.landmarks[i];
      ASSERT_TRUE(landmark < 0 || graph.feature_of(id, landmark) == static_cast<std::int64_t>(i));
    }
  }
  EXPECT_EQ(roots, 1);
}

class LoopClosingTest : public ::testing::TestWithParam<CameraKind> {};

TEST_P(LoopClosingTest, ClosesAConfirmedLoopAndRemovesTheDrift) {
  Bench bench(GetParam());
  bench.mapper.begin(0, SE3(), 1.0);
  std::optional<LoopResult> closed;
  double before = 0.0;
  for (int k = 0; k < 68 && !closed; ++k) {
    const std::int64_t id = bench.mapper.add(k * step);
    before = bench.error();
    closed = bench.loop_closing.process(id);
    ASSERT_TRUE(!closed || k >= 57) << "nothing was seen twice yet at " << k;
  }
  ASSERT_TRUE(closed);
  EXPECT_FALSE(closed->merged);
  EXPECT_LT(closed->matched, 8);
  EXPECT_GE(closed->landmarks, 40);
  EXPECT_GT(closed->fused, 20);
  EXPECT_EQ(closed->event().kind, "loop_closed");
  EXPECT_GT(before, 0.2);
  EXPECT_LT(bench.error(), 0.075 * before) << "measured: 0.045 and 0.048";
  GlobalBundleAdjustment adjustment(bench.graph, 0, bench.options.pixel_sigma);
  adjustment.run(10, nullptr, nullptr);
  adjustment.apply(bench.graph);
  EXPECT_LT(bench.error(), 0.065 * before) << "measured: 0.043 and 0.027";
  expect_sound(bench.graph);
  ASSERT_EQ(bench.graph.constraints().size(), 1U);
  EXPECT_GT(bench.graph.shared(closed->keyframe, closed->matched), 15) << "they now see the same landmarks";
  // A map unit has the same length everywhere.
  std::vector<double> lengths;
  for (const std::int64_t id : bench.graph.keyframe_ids())
    lengths.push_back(bench.mapper.scales[static_cast<std::size_t>(id)] * bench.graph.unit(id));
  const auto [least, most] = std::minmax_element(lengths.begin(), lengths.end());
  EXPECT_LT(*most / *least, 1.02);
  EXPECT_TRUE(GetParam() == CameraKind::mono || (*least == 1.0 && *most == 1.0));
}

TEST_P(LoopClosingTest, MergesASubmapOfAnotherUnitIntoTheOlderOne) {
  const bool mono = GetParam() == CameraKind::mono;
  for (const int first : {0, 1}) {
    Bench bench(GetParam());
    DriftingMapper exact(bench.world, bench.graph, 0.0, 1.0);
    exact.begin(first, SE3(), 1.0);
    for (int k = 0; k < 14; ++k) EXPECT_FALSE(bench.loop_closing.process(exact.add(k * step)));
    exact.begin(1 - first, SE3(SO3::exp({0.3, 1.0, -0.4}), {3.0, -2.0, 1.0}), mono ? 2.5 : 1.0);
    std::optional<LoopResult> merged;
    for (int k = 18; k > 4 && !merged; --k) merged = bench.loop_closing.process(exact.add(k * step));
    ASSERT_TRUE(merged);
    EXPECT_TRUE(merged->merged);
    EXPECT_EQ(merged->event().kind, "joined");
    EXPECT_NEAR(merged->scale, !mono ? 1.0 : first == 0 ? 0.4 : 2.5, 0.03);
    for (const std::int64_t id : bench.graph.keyframe_ids()) EXPECT_EQ(bench.graph.keyframe(id).submap, 0);
    expect_sound(bench.graph);
    EXPECT_LT(bench.error(exact), first == 0 ? 0.001 : 0.0025) << "measured: 0.00043 and 0.00046, of the larger unit";
    ASSERT_EQ(bench.graph.constraints().size(), 1U);
    EXPECT_EQ(bench.graph.constraints()[0].kind, ConstraintKind::merge);
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, LoopClosingTest, ::testing::Values(CameraKind::mono, CameraKind::depth));

TEST(LoopClosing, ALoopMustFindMoreLandmarksThanAWrongOneWould) {
  OrbSlamOptions options;
  options.loop_chance_ratio = 1000.0;
  Bench bench(CameraKind::mono, options);
  bench.mapper.begin(0, SE3(), 1.0);
  for (int k = 0; k < 68; ++k) EXPECT_FALSE(bench.loop_closing.process(bench.mapper.add(k * step))) << k;
}

/// Every second landmark of the first keyframes moves by a few pixels: within the search windows, but no similarity
/// fits all of them.
TEST(LoopClosing, TheLandmarksOfALoopMustBeWhereItPredictsThem) {
  for (const double least_share : {0.0, OrbSlamOptions().loop_fit_share}) {
    OrbSlamOptions options;
    options.loop_fit_share = least_share;
    Bench bench(CameraKind::depth, options);
    bench.mapper.begin(0, SE3(), 1.0);
    bool closed = false;
    for (int k = 0; k < 68 && !closed; ++k) {
      const std::int64_t id = bench.mapper.add(k * step);
      closed = bench.loop_closing.process(id).has_value();
      if (k != 30) continue;
      for (const std::int64_t landmark : bench.graph.landmark_ids()) {
        if (landmark % 2 == 0 && bench.graph.landmark(landmark).first_keyframe < 15)
          bench.graph.landmark(landmark).position += Eigen::Vector3d(0.0, 0.15, 0.0);
      }
    }
    EXPECT_EQ(closed, least_share == 0.0);
  }
}

/// To the other side of the circle and back: nearly all of the path is the first and the last step.
TEST(LoopClosing, ALoopMayBeAsFarOffAsTheWholePathDrifts) {
  constexpr std::int64_t back = 5;
  const auto drive = [&](Bench& bench) {
    bench.mapper.begin(0, RoundWorld::world_from_camera(0.0), 1.0);
    bench.mapper.add(0.0);
    for (int k = 0; k < 4; ++k) bench.mapper.add(M_PI + k * step);
    EXPECT_EQ(bench.mapper.add(0.0), back);
  };
  OrbSlamOptions options;
  options.loop_consistent = 1;
  Bench measured(CameraKind::depth, options);
  drive(measured);
  double path = 0.0;
  for (std::int64_t id = 1; id <= back; ++id) {
    const SE3 moved = measured.graph.camera_from_world(id - 1) * measured.graph.camera_from_world(id).inverse();
    path += moved.translation().norm() + moved.rotation().log().norm();
  }
  const SE3 off = measured.graph.camera_from_world(back) * measured.graph.camera_from_world(0).inverse();
  const double sigmas =
      graph_sigmas(off, SE3(), OdometryDrift{options.loop_drift_share, options.loop_drift_rad_per_m}.covariance(path));
  for (const double limit : {0.8, 1.2}) {
    options.loop_max_sigmas = limit * sigmas;
    Bench bench(CameraKind::depth, options);
    drive(bench);
    EXPECT_EQ(bench.loop_closing.process(back).has_value(), limit > 1.0) << limit;
  }
}

/// A loop from keyframe `from` to `to`, off by 0.3 m, in a row of keyframes 0 to 3 of which only the first two share
/// landmarks.
MapGraph with_corrected_loop(const testing::PointWorld& world, std::int64_t from, std::int64_t to, bool branched) {
  MapGraph graph(world.camera, CameraKind::depth, 0.1, OrbOptions{});
  testing::ExactMap map(world, graph);
  const auto at = [](double k) { return SE3(SO3(), {-0.2 * k, 0.0, 0.0}); };
  map.add(0, at(0), {.from = 0, .to = 100});
  map.add(1, at(1), {.from = 0, .to = 100});
  map.add(2, at(2), {.from = 100, .to = 200});
  map.add(3, at(3), {.from = 200, .to = 300});
  if (branched) graph.set_parent(2, 0);
  VerifiedLoop loop;
  loop.keyframe = from;
  loop.matched = to;
  const SE3 measured = graph.camera_from_world(from) * graph.camera_from_world(to).inverse();
  loop.keyframe_from_matched = Sim3(SE3(measured.rotation(), measured.translation() + Eigen::Vector3d(0.0, 0.3, 0.0)));
  correct_loop(graph, OrbSlamOptions(), loop);
  return graph;
}

TEST(LoopCorrection, HoldsTheRootAlsoWhereItIsAmongThoseThatMove) {
  const testing::PointWorld world(300, 5);
  const auto moved_by = [](const MapGraph& graph, std::int64_t id) {
    const SE3 before(SO3(), {-0.2 * static_cast<double>(id), 0.0, 0.0});
    return (graph.camera_from_world(id).inverse() * before).translation().norm();
  };
  const MapGraph forward = with_corrected_loop(world, 3, 1, false);
  EXPECT_LT(moved_by(forward, 0), 1e-9);
  EXPECT_GT(moved_by(forward, 3), 0.05);
  for (const bool branched : {false, true}) {
    const MapGraph backward = with_corrected_loop(world, 1, 3, branched);
    EXPECT_LT(moved_by(backward, 0), 1e-9) << branched << ": it observes what keyframe 1 does";
    EXPECT_GT(moved_by(backward, 2), 0.01) << branched;
    EXPECT_GT(moved_by(backward, 3), 0.05) << branched;
  }
}

TEST(LoopClosing, SameInputSameBytes) {
  const auto run = [] {
    Bench bench(CameraKind::mono);
    bench.mapper.begin(0, SE3(), 1.0);
    bool closed = false;
    for (int k = 0; k < 68 && !closed; ++k) closed = bench.loop_closing.process(bench.mapper.add(k * step)).has_value();
    std::vector<double> numbers;
    for (const std::int64_t id : bench.graph.keyframe_ids()) {
      const Eigen::Matrix4d matrix = bench.graph.keyframe(id).camera_from_world.matrix();
      numbers.insert(numbers.end(), matrix.data(), matrix.data() + 16);
    }
    return numbers;
  };
  EXPECT_EQ(run(), run());
}

TEST(FrameRelocalizer, FindsAFrameAnywhereInTheMapAndNoneElsewhere) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    Bench bench(sensor);
    DriftingMapper exact(bench.world, bench.graph, 0.0, 1.0);
    exact.begin(0, RoundWorld::world_from_camera(0.0), 1.0);
    for (int k = 0; k < 20; ++k) exact.add(k * step);
    FrameRelocalizer relocalizer(bench.options, bench.graph, bench.database);
    std::vector<std::uint32_t> seen;
    for (const double angle : {3.3 * step, 11.6 * step}) {
      // Slightly off the trajectory, and rotated.
      const SE3 ground_truth =
          RoundWorld::world_from_camera(angle) * SE3(SO3::exp({0.05, -0.05, 0.2}), {0.1, 0.1, -0.3});
      const auto frame = bench.world.frame(100, ground_truth, bench.graph.baseline(), seen);
      const auto found = relocalizer.find(*frame, 30);
      ASSERT_TRUE(found);
      EXPECT_GT(found->inliers, 80);
      EXPECT_LT((found->camera_from_world * ground_truth).log().norm(), 0.02);
    }
    const auto elsewhere =
        bench.world.frame(101, RoundWorld::world_from_camera(M_PI * 1.3), bench.graph.baseline(), seen);
    EXPECT_FALSE(relocalizer.find(*elsewhere, 30));
    RoundWorld other(9);
    EXPECT_FALSE(relocalizer.find(*other.frame(102, RoundWorld::world_from_camera(0.5), 0.0, seen), 30));
    EXPECT_FALSE(relocalizer.find(FeatureFrame(std::make_shared<ImageFeatures>(), bench.world.camera, 0.0), 30));
  }
}

}  // namespace
}  // namespace rastro
