// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/keyframe_pipeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/session_testing.h"

namespace rastro {
namespace {

using testing::pose_near;
using testing::SessionBench;

constexpr TimeNs second = 1000000000;

OrbSlamOptions without_culling() {
  OrbSlamOptions options;
  options.cull_seen_share = 1.0;
  return options;
}

std::vector<std::string> kinds_of(const std::vector<SlamEvent>& events) {
  std::vector<std::string> kinds;
  for (const SlamEvent& event : events) kinds.push_back(event.kind);
  return kinds;
}

/// Three keyframes, and a fourth in flight since frame 10.
struct PipelineBench : SessionBench {
  explicit PipelineBench(const OrbSlamOptions& options = without_culling(), const SlamContext& context = {})
      : SessionBench(CameraKind::depth, options, context) {
    begin(3);
    session.frame_number = 10;
    pipeline.insert(input(10, 2.2, 2), second);
  }
  /// Center of tracking's view after it took the results for a frame.
  std::int64_t center_at(std::int64_t frame, TimeNs stamp) {
    session.frame_number = frame;
    pipeline.take_results(stamp, events);
    return tracker.view()->center;
  }

  std::vector<SlamEvent> events;
};

TEST(KeyframePipeline, HandsTheViewOverAfterTheGivenFramesAndTime) {
  PipelineBench bench;
  EXPECT_FALSE(bench.pipeline.idle());
  EXPECT_EQ(bench.center_at(11, 2 * second), 2);
  EXPECT_EQ(bench.center_at(12, second + 180000000 - 1), 2);
  EXPECT_FALSE(bench.pipeline.idle());
  EXPECT_EQ(bench.center_at(12, second + 180000000), 3);
  EXPECT_TRUE(bench.pipeline.idle());
}

TEST(KeyframePipeline, WithConstantStampsOnlyFramesCount) {
  PipelineBench bench;
  EXPECT_EQ(bench.center_at(10 + 2 + 19, second), 2);
  EXPECT_EQ(bench.center_at(10 + 2 + 20, second), 3);
}

TEST(KeyframePipeline, TakesAllResultsInFlightInOrder) {
  PipelineBench bench;
  bench.pipeline.insert(bench.input(11, 2.4, 2), second);
  bench.pipeline.take_all_results(bench.events);
  EXPECT_TRUE(bench.pipeline.idle());
  EXPECT_EQ(bench.tracker.view()->center, 4);
  EXPECT_TRUE(bench.events.empty());
}

TEST(KeyframePipeline, OnlyKeyframesOfTheMapHaveAnUncertainty) {
  PipelineBench bench{OrbSlamOptions()};
  for (std::int64_t id = 0; id < 3; ++id)
    bench.session.uncertainty.set(id, Eigen::Vector3d::Zero(), Matrix6d::Identity());
  bench.pipeline.insert(bench.input(11, 2.4, 2), second);
  bench.pipeline.take_all_results(bench.events);
  int removed = 0;
  for (std::int64_t id = 0; id < 3; ++id) {
    EXPECT_EQ(bench.session.uncertainty.contains(id), bench.session.graph.has_keyframe(id)) << id;
    removed += bench.session.graph.has_keyframe(id) ? 0 : 1;
  }
  EXPECT_GT(removed, 0) << "they see the same";
}

TEST(KeyframePipeline, LostTrackingKeepsTheView) {
  PipelineBench bench;
  bench.session.tracking = false;
  bench.pipeline.take_all_results(bench.events);
  EXPECT_TRUE(bench.pipeline.idle());
  EXPECT_EQ(bench.tracker.view()->center, 2);
}

TEST(KeyframePipeline, AThreadBesideMakesTheSameMap) {
  TaskPool pool(2);
  SlamContext beside;
  beside.pool = &pool;
  beside.pipelined = true;
  PipelineBench alone, other(without_culling(), beside);
  other.pipeline.wait();
  EXPECT_EQ(alone.session.graph.landmark_ids(), other.session.graph.landmark_ids());
  EXPECT_EQ(alone.session.graph.camera_from_world(3).matrix(), other.session.graph.camera_from_world(3).matrix());
}

/// A second submap; the keyframe in flight shows that it is the first one.
struct LoopBench : SessionBench {
  explicit LoopBench(const OrbSlamOptions& options) : SessionBench(CameraKind::depth, options) {
    begin(3);
    std::fill(map.landmark_of.begin(), map.landmark_of.end(), -1);
    map.add(3, stop(1.0), {.to = 200}, 1);
    session.next_keyframe = 4;
    stand_at(3, {.to = 200});
    session.frame_number = 10;
    session.last_stamp = second;
    pipeline.insert(input(10, 1.1, 3), second);
    inserted = session.graph.camera_from_world(4);
  }
  static OrbSlamOptions sure_at_once() {
    OrbSlamOptions options = without_culling();
    options.loop_consistent = 1;
    options.loop_adjust_delay_s = 100.0;
    return options;
  }
  std::vector<std::string> kinds_at(std::int64_t frame, TimeNs stamp) {
    session.frame_number = frame;
    std::vector<SlamEvent> events;
    pipeline.take_results(stamp, events);
    return kinds_of(events);
  }

  SE3 inserted;
};

using Kinds = std::vector<std::string>;

TEST(KeyframePipeline, AClosedLoopIsAdjustedBesideMappingAndThenApplied) {
  LoopBench bench(LoopBench::sure_at_once());
  EXPECT_EQ(bench.session.graph.submap(3), 0);
  bench.session.graph.keyframe(2).camera_from_world = SE3(SO3(), {0.0, 0.05, 0.0}) * bench.stop(2);
  EXPECT_EQ(bench.kinds_at(12, 2 * second), Kinds{"joined"});
  const GlobalBundleAdjustment whole(bench.session.graph, 0, 1.0);
  const TimeNs ready = second + from_seconds(100.0 * static_cast<double>(whole.observations()) / 1e5);
  ASSERT_GT(ready, 2 * second);
  EXPECT_TRUE(bench.kinds_at(14, ready - 1).empty());
  EXPECT_TRUE(bench.pipeline.idle());
  EXPECT_TRUE(bench.kinds_at(14, ready).empty());
  EXPECT_FALSE(bench.pipeline.idle()) << "mapping takes it over";
  EXPECT_EQ(bench.kinds_at(16, ready + second), Kinds{"adjusted"});
  EXPECT_TRUE(bench.pipeline.idle());
  EXPECT_EQ(bench.tracker.view()->center, 4);
  const SE3 adjusted = bench.tracker.view()->keyframe(2).camera_from_world;
  EXPECT_THAT(adjusted, pose_near(bench.session.graph.camera_from_world(2), 0.0, 0.0));
}

TEST(KeyframePipeline, WithConstantStampsAnAdjustmentIsReadyAfterManyFrames) {
  LoopBench bench(LoopBench::sure_at_once());
  EXPECT_EQ(bench.kinds_at(32, second), Kinds{"joined"});
  EXPECT_TRUE(bench.kinds_at(32 + 2 + 399, second).empty());
  EXPECT_TRUE(bench.pipeline.idle());
  bench.kinds_at(32 + 2 + 400, second);
  EXPECT_FALSE(bench.pipeline.idle());
}

TEST(KeyframePipeline, LoopsAndTheirAdjustmentCanBeDisabled) {
  OrbSlamOptions options = LoopBench::sure_at_once();
  options.loop_adjust_iterations = 0;
  LoopBench unadjusted(options);
  EXPECT_EQ(unadjusted.kinds_at(12, 2 * second), Kinds{"joined"});
  EXPECT_TRUE(unadjusted.kinds_at(10000, 10000 * second).empty());
  EXPECT_TRUE(unadjusted.pipeline.idle());
  options.loop_closing = false;
  LoopBench open(options);
  EXPECT_TRUE(open.kinds_at(12, 2 * second).empty());
  EXPECT_EQ(open.session.graph.submap(3), 1);
}

TEST(KeyframePipeline, AClosedLoopIsAdjustedByTheEndUnlessPausedOrStopped) {
  const OrbSlamOptions options = LoopBench::sure_at_once();
  std::vector<SlamEvent> events;
  LoopBench finished(options);
  finished.pipeline.finish(events);
  EXPECT_EQ(kinds_of(events), (Kinds{"joined", "adjusted"}));
  LoopBench paused(options);
  events.clear();
  paused.pipeline.pause(events);
  EXPECT_TRUE(paused.pipeline.idle());
  paused.pipeline.finish(events);
  EXPECT_EQ(kinds_of(events), Kinds{"joined"});
  LoopBench stopped(options);
  const std::atomic<bool> stop = true;
  stopped.session.stop = &stop;
  events.clear();
  stopped.pipeline.finish(events);
  EXPECT_EQ(kinds_of(events), Kinds{"joined"});
}

/// Error of keyframe 1, moved by 0.05 m, at the end of the run.
double error_after_finish(const OrbSlamOptions& options, bool mapping, const std::atomic<bool>* stop = nullptr,
                          bool has_map = true) {
  SessionBench bench(CameraKind::depth, options);
  bench.begin(3);
  bench.session.graph.keyframe(1).camera_from_world = SE3(SO3(), {0.0, 0.05, 0.0}) * bench.stop(1);
  bench.session.mapping = mapping;
  bench.session.stop = stop;
  bench.session.has_map = has_map;
  std::vector<SlamEvent> events;
  bench.pipeline.finish(events);
  return (bench.session.graph.camera_from_world(1).translation() - bench.stop(1).translation()).norm();
}

TEST(KeyframePipeline, ASmallMapIsAdjustedAtTheEndIfAllowed) {
  OrbSlamOptions options;
  options.final_keyframes = 3;
  options.final_iterations = 20;
  EXPECT_LT(error_after_finish(options, true), 1e-3);
  EXPECT_NEAR(error_after_finish(options, false), 0.05, 1e-12) << "localization leaves the map alone";
  const std::atomic<bool> stop = true;
  EXPECT_NEAR(error_after_finish(options, true, &stop), 0.05, 1e-12);
  EXPECT_NEAR(error_after_finish(options, true, nullptr, false), 0.05, 1e-12);
  options.final_keyframes = 2;
  EXPECT_NEAR(error_after_finish(options, true), 0.05, 1e-12) << "one keyframe too many";
  options.final_keyframes = 3;
  options.final_iterations = 0;
  EXPECT_NEAR(error_after_finish(options, true), 0.05, 1e-12);
  options.final_iterations = 1;
  EXPECT_LT(error_after_finish(options, true), 0.03);
}

TEST(KeyframePipeline, TheTrajectoryIsRefinedAtTheEndWithHalfTheInliers) {
  for (const std::uint32_t seen : {14U, 15U}) {
    OrbSlamOptions options;
    options.min_inliers = 30;
    options.final_iterations = 0;
    SessionBench bench(CameraKind::depth, options);
    bench.begin(3);
    const testing::Observed observed = bench.observe(5, bench.stop(1.5), {.to = seen});
    FrameMeasurements measured;
    for (const TrackedPoint& point : bench.map.tracked(observed))
      measured.seen.push_back({point.landmark, observed.frame->ray(point.feature).cast<float>(),
                               static_cast<float>(observed.frame->right_ray(point.feature)), 0.002F});
    ASSERT_EQ(measured.seen.size(), seen);
    bench.session.trajectory.add({5, second, 1, 1.0, SE3(SO3(), {-0.1, 0.02, 0.0}), -1,
                                  std::make_shared<const FrameMeasurements>(std::move(measured))});
    std::vector<SlamEvent> events;
    bench.pipeline.finish(events);
    const Trajectory poses = bench.session.trajectory.trajectory(bench.session.graph, 0);
    EXPECT_NEAR(poses[0].world_from_body.translation().y(), seen == 15 ? 0.0 : -0.02, 1e-4);
  }
}

/// Counts the maps it gets.
struct CountingArchive : MapArchive {
  bool wants_map() const override { return wants; }
  void keep(std::shared_ptr<const Map> map) override { kept.push_back(std::move(map)); }
  void add_images(KeyframeId, PackedImages) override {}
  std::shared_ptr<const ImageStore> images() const override { return nullptr; }

  bool wants = true;
  std::vector<std::shared_ptr<const Map>> kept;
};

TEST(KeyframePipeline, TheMapIsArchivedWhenItGrowsAndNoJobIsInFlight) {
  CountingArchive archive;
  SlamContext context;
  context.archive = &archive;
  PipelineBench bench(without_culling(), context);
  bench.session.given = GivenMap{MapScale{true, 0.5, "a known length"}, {}};
  bench.pipeline.archive_map();
  EXPECT_EQ(archive.kept.size(), 0U) << "a keyframe is being processed";
  bench.pipeline.take_all_results(bench.events);
  ASSERT_EQ(archive.kept.size(), 1U);
  EXPECT_EQ(archive.kept[0]->keyframes.size(), 4U);
  EXPECT_EQ(archive.kept[0]->sessions[0].scale.origin, "a known length");
  bench.session.mapping = false;
  bench.pipeline.archive_map();
  bench.session.mapping = true;
  archive.wants = false;
  bench.pipeline.archive_map();
  EXPECT_EQ(archive.kept.size(), 1U);
  archive.wants = true;
  bench.pipeline.finish(bench.events);
  EXPECT_EQ(archive.kept.size(), 2U);
}

TEST(KeyframePipeline, TheFullerTheMapTheSparserItsKeyframes) {
  PipelineBench unlimited;
  unlimited.pipeline.take_all_results(unlimited.events);
  const std::size_t bytes = MapThinning(unlimited.session.options, unlimited.session.graph, 1).memory(0).bytes;
  const std::pair<double, std::pair<double, double>> expected[] = {
      {3.0, {1.0, 1.0}}, {1.6, {1.5, 0.9}}, {1.2, {2.0, 0.8}}, {0.9, {3.0, 0.7}}};
  for (const auto& [share, then] : expected) {
    SlamContext context;
    context.map_memory_bytes = static_cast<std::size_t>(share * static_cast<double>(bytes));
    PipelineBench bench(without_culling(), context);
    TrackedFrame frame;
    frame.measured = std::make_shared<FrameMeasurements>();
    bench.session.trajectory.add(frame);
    bench.pipeline.take_all_results(bench.events);
    EXPECT_EQ(bench.session.spacing, then.first) << share;
    EXPECT_EQ(bench.session.trajectory.frames().front().measured == nullptr, then.first >= 2.0) << share;
    EXPECT_NEAR(bench.session.keyframe_share, then.second, 1e-12) << share;
    EXPECT_EQ(bench.events.size(), then.first > 1.0 ? 1U : 0U) << share;
  }
}

}  // namespace
}  // namespace rastro
