// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/relocalization/frame_relocalizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/tracking/frame_testing.h"

namespace rastro {
namespace {

using testing::ExactMap;
using testing::ObserveOptions;
using testing::PointWorld;
using testing::pose_near;

SE3 aside(double k) { return SE3(SO3(), {-0.2 * k, 0.0, 0.0}); }

/// An exact map of keyframes, with the standard vocabulary.
struct RelocalizerBench {
  explicit RelocalizerBench(CameraKind sensor = CameraKind::mono)
      : map(world, sensor, sensor == CameraKind::mono ? 0.0 : 0.1), database(map.graph, standard_vocabulary()) {}

  std::optional<Relocation> find(const SE3& camera_from_world, const OrbSlamOptions& options, ObserveOptions how = {}) {
    how.baseline = map.graph.baseline();
    return FrameRelocalizer(options, map.graph, database)
        .find(*world.observe(50, camera_from_world, how).frame, options.min_inliers);
  }

  PointWorld world{300, 5};
  ExactMap map;
  KeyframeDatabase database;
};

const SE3 off_track(SO3::exp({0.02, -0.03, 0.1}), {-0.25, 0.05, 0.3});

TEST(FrameRelocalizer, FindsTheExactPoseByTheMostSimilarKeyframe) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    RelocalizerBench bench(sensor);
    bench.map.add(0, aside(0), {.to = 150});
    bench.map.add(1, aside(1));
    bench.map.add(2, aside(2), {.from = 150});
    const auto found = bench.find(off_track, {});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->keyframe, 1);
    EXPECT_THAT(found->camera_from_world, pose_near(off_track, 2e-4, 2e-5));
    EXPECT_GT(found->inliers, 290);
  }
}

TEST(FrameRelocalizer, LandmarksOfTheNeighborsCountToo) {
  RelocalizerBench bench;
  bench.map.add(0, aside(0), {.to = 200});
  bench.map.add(1, aside(1), {.from = 100});
  OrbSlamOptions options;
  const auto all = bench.find(aside(0.5), options);
  ASSERT_TRUE(all);
  EXPECT_GT(all->inliers, 290);
  options.covisible_landmarks = 101;
  const auto own = bench.find(aside(0.5), options);
  ASSERT_TRUE(own);
  EXPECT_LE(own->inliers, 200) << "they share 100";
}

TEST(FrameRelocalizer, NeedsEnoughMatchesAndInliers) {
  RelocalizerBench bench;
  bench.map.add(0, aside(0));
  bench.map.add(1, aside(1));
  const ObserveOptions forty{.to = 40};
  OrbSlamOptions options;
  options.min_inliers = 20;
  const auto found = bench.find(aside(0.5), options, forty);
  ASSERT_TRUE(found);
  options.min_inliers = found->inliers;
  EXPECT_GT(found->inliers, 35);
  EXPECT_TRUE(bench.find(aside(0.5), options, forty));
  options.min_inliers = found->inliers + 1;
  EXPECT_FALSE(bench.find(aside(0.5), options, forty));
  options.min_inliers = 20;
  options.relocalize_matches = 40;
  EXPECT_TRUE(bench.find(aside(0.5), options, forty));
  options.relocalize_matches = 41;
  EXPECT_FALSE(bench.find(aside(0.5), options, forty));
}

TEST(FrameRelocalizer, TriesNoMoreKeyframesThanAllowed) {
  RelocalizerBench bench;
  bench.map.add(0, aside(0));
  bench.map.add(1, aside(1), {.to = 200});
  // The most similar one has no landmarks.
  for (const std::int64_t id : bench.map.graph.landmark_ids()) bench.map.graph.remove_observation(0, id);
  OrbSlamOptions options;
  options.place_shared_words = 0.5;
  options.place_candidates = 1;
  EXPECT_FALSE(bench.find(aside(0.9), options));
  options.place_candidates = 2;
  const auto found = bench.find(aside(0.9), options);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->keyframe, 1);
  options.place_shared_words = 0.8;
  EXPECT_FALSE(bench.find(aside(0.9), options)) << "it shares two thirds of the words";
}

TEST(FrameRelocalizer, TheSeedDecidesWhichMatchesAreSampled) {
  RelocalizerBench bench;
  bench.map.add(0, aside(0));
  OrbSlamOptions options;
  options.pnp_iterations = 1;
  int found = 0;
  constexpr int seeds = 20;
  for (options.seed = 1; options.seed <= seeds; ++options.seed)
    found += bench.find(off_track, options, {.moved_share = 0.3}) ? 1 : 0;
  EXPECT_GT(found, 0);
  EXPECT_LT(found, seeds);
}

TEST(FrameRelocalizer, IsRobustToWrongFeaturesAndNoise) {
  RelocalizerBench bench;
  for (int k = 0; k < 3; ++k) bench.map.add(k, aside(k));
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto found = bench.find(off_track, {}, {.noise_px = 0.5, .moved_share = 0.3, .seed = seed});
    ASSERT_TRUE(found);
    EXPECT_THAT(found->camera_from_world, pose_near(off_track, 0.03, 0.004));
    EXPECT_GT(found->inliers, 170);
    EXPECT_LT(found->inliers, 225);
  }
}

}  // namespace
}  // namespace rastro
