// SPDX-License-Identifier: Apache-2.0
// How many frames keep their observations, and how many keyframes may wait.
#include <gtest/gtest.h>

#include "rastro/slam/orb/session_testing.h"

namespace rastro {
namespace {

using testing::SessionBench;

/// Three keyframes, and frames that stand at stop 1 but were tracked 0.02 m off, with `seen` observations each.
struct LongRun : SessionBench {
  LongRun(int frames, std::uint32_t seen, const OrbSlamOptions& options = thirty_inliers())
      : SessionBench(CameraKind::depth, options) {
    begin(3);
    const testing::Observed observed = observe(5, stop(1), {.to = seen});
    auto measured = std::make_shared<FrameMeasurements>();
    for (const TrackedPoint& point : map.tracked(observed))
      measured->seen.push_back({point.landmark, observed.frame->ray(point.feature).cast<float>(),
                                static_cast<float>(observed.frame->right_ray(point.feature)), 0.002F});
    EXPECT_EQ(measured->seen.size(), seen);
    TrackedFrame frame = {0, 0, 1, 1.0, SE3(SO3(), {0.0, 0.02, 0.0}), -1, measured};
    for (; frame.index < frames; ++frame.index) session.trajectory.add(frame);
  }
  static OrbSlamOptions thirty_inliers() {
    OrbSlamOptions options;
    options.min_inliers = 30;
    options.cull_seen_share = 1.0;
    return options;
  }
  int with_observations() const {
    const auto& frames = session.trajectory.frames();
    return static_cast<int>(std::count_if(frames.begin(), frames.end(),
                                          [](const TrackedFrame& frame) { return frame.measured != nullptr; }));
  }
  /// Frames whose pose is the keyframe's now.
  int refined() const {
    const auto& frames = session.trajectory.frames();
    return static_cast<int>(std::count_if(frames.begin(), frames.end(), [](const TrackedFrame& frame) {
      return frame.camera_from_keyframe.translation().norm() < 1e-3;
    }));
  }

  std::vector<SlamEvent> events;
};

/// Half the inliers of tracking are enough.
TEST(KeyframePipeline, AllButTheLastFramesAreRefinedWithTheNextKeyframe) {
  for (const auto& [frames, seen, taken, better] :
       {std::tuple{620, 15U, 120, 120}, {600, 15U, 100, 100}, {599, 15U, 0, 0}, {620, 14U, 120, 0}}) {
    LongRun run(frames, seen);
    run.pipeline.insert(run.input(10, 2.2, 2), 0);
    EXPECT_EQ(run.with_observations(), frames - taken);
    EXPECT_EQ(run.refined(), 0) << "as long as the keyframe is in flight";
    run.pipeline.take_all_results(run.events);
    EXPECT_EQ(run.refined(), better) << frames << ' ' << seen;
    for (int k = 0; k < frames; ++k)
      EXPECT_EQ(run.session.trajectory.frames()[static_cast<std::size_t>(k)].measured == nullptr, k < taken);
  }
}

TEST(KeyframePipeline, WithoutMappingOldObservationsAreDroppedEveryHundredFrames) {
  for (const auto& [mapping, number, left] :
       {std::tuple{false, 700, 500}, {false, 701, 620}, {false, 750, 620}, {true, 700, 620}}) {
    LongRun run(620, 1);
    run.session.mapping = mapping;
    run.session.frame_number = number;
    run.pipeline.take_results(0, run.events);
    EXPECT_EQ(run.with_observations(), left) << mapping << ' ' << number;
    EXPECT_EQ(run.refined(), 0);
  }
}

TEST(KeyframePipeline, InALiveRunFourKeyframesMayWait) {
  for (const bool live : {true, false}) {
    SlamContext context;
    context.live = live;
    SessionBench bench(CameraKind::depth, LongRun::thirty_inliers(), context);
    bench.begin(3);
    for (int k = 0; k < 4; ++k) {
      EXPECT_TRUE(bench.pipeline.accepts()) << k;
      bench.pipeline.insert(bench.input(10 + k, 2.2 + 0.2 * k, 2), 0);
    }
    EXPECT_EQ(bench.pipeline.accepts(), !live);
    EXPECT_EQ(bench.pipeline.dropped_frames(), live ? 1 : 0);
    std::vector<SlamEvent> events;
    bench.session.frame_number = 1;
    bench.pipeline.take_results(1, events);
    EXPECT_EQ(bench.pipeline.idle(), live) << "handed over as soon as they are ready, else after the delay";
    EXPECT_TRUE(bench.pipeline.accepts());
    EXPECT_FALSE(bench.pipeline.settled(1)) << "a live run takes no more keyframes than one that waits for the delay";
  }
}

}  // namespace
}  // namespace rastro
