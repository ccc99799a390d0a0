// SPDX-License-Identifier: Apache-2.0
// Which landmarks and keyframes local mapping takes out again.
#include <gtest/gtest.h>

#include "rastro/slam/orb/local_mapping/mapping_testing.h"

namespace rastro {
namespace {

using testing::mapping_pose;
using testing::MappingBench;
using testing::Observed;
using testing::without_keyframe_culling;
using IdList = std::vector<std::int64_t>;

/// All keyframes observe its points.
struct CullingBench : MappingBench {
  explicit CullingBench(CameraKind sensor, const OrbSlamOptions& changed = {}) : MappingBench(sensor, changed) {
    for (Eigen::Vector3d& point : world.points) point.x() *= 0.5;
  }
};

/// Five keyframes of 200 points, the first two in a loop constraint; of keyframe 2, `points` points are observed by
/// `others` others.
void add_keyframes_with_points_of_few(CullingBench& bench, std::size_t points, std::size_t others) {
  for (int id = 0; id < 5; ++id) bench.add_keyframe(id);
  bench.map.graph.constraints() = {{.from = 0, .to = 1, .from_from_to = {}, .inliers = 9}};
  const IdList order{0, 1, 3, 4};
  for (std::size_t point = 0; point < points; ++point) {
    for (std::size_t k = others; k < order.size(); ++k)
      bench.map.graph.remove_observation(order[k], bench.map.landmark_of[point]);
  }
}

/// The keyframes left after processing a keyframe that observes all but the first 60 points.
IdList left_after_culling(CullingBench& bench, std::int64_t newest = 5) {
  KeyframeInput input = bench.input(newest, 4);
  std::erase_if(input.points, [&](const TrackedPoint& point) {
    const auto at = std::find(bench.map.landmark_of.begin(), bench.map.landmark_of.end(), point.landmark);
    return at - bench.map.landmark_of.begin() < 60;
  });
  // Fusion finds nothing else: its features have no similar descriptors.
  auto data = std::make_shared<ImageFeatures>(input.frame->data());
  for (std::uint32_t i = 0; i < data->features.size(); ++i) {
    const bool tracked = std::any_of(input.points.begin(), input.points.end(),
                                     [&](const TrackedPoint& point) { return point.feature == i; });
    if (tracked) continue;
    for (auto& word : data->features.descriptors[i].words) word = ~word;
    if (!data->depths.empty()) data->depths[i] = 0.0F;
  }
  input.frame = std::make_shared<FeatureFrame>(std::move(data), bench.world.camera, bench.map.graph.baseline());
  bench.mapping.process(input);
  return bench.map.graph.keyframe_ids();
}

OrbSlamOptions near_to(double meters) {
  OrbSlamOptions options;
  options.far_baselines = 10.0 * meters;
  return options;
}

bool contains(const IdList& ids, std::int64_t id) { return std::count(ids.begin(), ids.end(), id) == 1; }

TEST(KeyframeCulling, AKeyframeStaysWithEnoughLandmarksThatFewerThanThreeOthersObserve) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    // Of 200 landmarks, 180 are 90 %: more than that must be observed by three others.
    CullingBench stays(sensor, near_to(20.0)), goes(sensor, near_to(20.0)), by_three(sensor, near_to(20.0));
    add_keyframes_with_points_of_few(stays, 20, 2);
    add_keyframes_with_points_of_few(goes, 19, 2);
    add_keyframes_with_points_of_few(by_three, 20, 3);
    EXPECT_TRUE(contains(left_after_culling(stays), 2));
    EXPECT_FALSE(contains(left_after_culling(goes), 2));
    EXPECT_FALSE(contains(left_after_culling(by_three), 2));
  }
}

TEST(KeyframeCulling, OthersCountOnlyIfTheyObserveALandmarkAtAboutTheSameLevel) {
  for (const int coarser : {1, 2}) {
    CullingBench bench(CameraKind::mono);
    for (int id = 0; id < 5; ++id) bench.add_keyframe(id);
    // Keyframe 2 observes everything at the finest level, all others at much coarser ones.
    for (const std::int64_t id : {0, 1, 2, 3, 4}) {
      MapKeyframe& keyframe = bench.map.graph.keyframe(id);
      auto data = std::make_shared<ImageFeatures>(keyframe.frame->data());
      data->features.levels.assign(data->features.size(), static_cast<std::uint8_t>(id == 2 ? 0 : coarser));
      keyframe.frame = std::make_shared<FeatureFrame>(std::move(data), bench.world.camera, 0.0);
    }
    EXPECT_EQ(contains(left_after_culling(bench), 2), coarser == 2);
  }
}

TEST(KeyframeCulling, WithDepthFarLandmarksDoNotCount) {
  // Of the points that the newest does not observe, those observed by two others are the 15 nearest: 7 % of all.
  const testing::PointWorld world = CullingBench(CameraKind::depth).world;
  std::vector<double> depths;
  for (std::size_t point = 0; point < 60; ++point) depths.push_back(world.points[point].z());
  std::sort(depths.begin(), depths.end());
  const double near_m = 0.5 * (depths[14] + depths[15]);
  for (const double far_m : {20.0, near_m}) {
    CullingBench bench(CameraKind::depth, near_to(far_m));
    add_keyframes_with_points_of_few(bench, 0, 0);
    for (std::size_t point = 0; point < 60; ++point) {
      if (world.points[point].z() > near_m) continue;
      for (const std::int64_t id : {3, 4}) bench.map.graph.remove_observation(id, bench.map.landmark_of[point]);
    }
    EXPECT_EQ(contains(left_after_culling(bench), 2), far_m == near_m);
  }
}

TEST(KeyframeCulling, TheRootAndTheLastTwoStay) {
  for (const std::int64_t newest : {5, 6}) {
    CullingBench bench(CameraKind::mono);
    for (int id = 0; id < 5; ++id) bench.add_keyframe(id);
    bench.map.graph.constraints() = {{.from = 1, .to = 2, .from_from_to = {}, .inliers = 9},
                                     {.from = 1, .to = 3, .from_from_to = {}, .inliers = 9}};
    EXPECT_EQ(left_after_culling(bench, newest), newest == 5 ? (IdList{0, 1, 2, 3, 4, 5}) : (IdList{0, 1, 2, 3, 6}));
  }
}

TEST(KeyframeCulling, OnlyKeyframesThatShareEnoughAreConsidered) {
  for (const int least : {140, 141}) {
    OrbSlamOptions options;
    options.covisible_landmarks = least;
    CullingBench bench(CameraKind::mono, options);
    for (int id = 0; id < 5; ++id) bench.add_keyframe(id);
    EXPECT_EQ(contains(left_after_culling(bench), 2), least == 141) << "the newest has 140 landmarks of it";
  }
}

TEST(KeyframeCulling, EitherEndOfALoopStays) {
  for (const bool from : {false, true}) {
    CullingBench bench(CameraKind::mono);
    for (int id = 0; id < 5; ++id) bench.add_keyframe(id);
    Constraint loop;
    loop.from = from ? 2 : 0;
    loop.to = from ? 0 : 2;
    bench.map.graph.constraints() = {loop};
    EXPECT_EQ(left_after_culling(bench), (IdList{0, 2, 4, 5}));
  }
}

/// Landmarks created by a keyframe with depth, by the points it observes, and those that later keyframes leave.
struct LandmarkBench : MappingBench {
  LandmarkBench() : MappingBench(CameraKind::depth, lasting()) {
    const Observed first = observe(0, SE3());
    mapping.initialize(first.frame, 0);
    for (std::uint32_t i = 0; i < first.seen.size(); ++i)
      map.landmark_of[first.seen[i]] = map.graph.keyframe(0).landmarks[i];
  }
  static OrbSlamOptions lasting() {
    OrbSlamOptions options = without_keyframe_culling();
    options.far_baselines = 200.0;
    return options;
  }
  void process(std::int64_t id, const std::vector<std::int64_t>& visible = {},
               const std::vector<std::int64_t>& found = {}) {
    KeyframeInput made = input_by_truth(id);
    for (const std::int64_t landmark : visible) ++made.counts[landmark].visible;
    for (const std::int64_t landmark : found) ++made.counts[landmark].found;
    mapping.process(made);
  }
  /// Of the first half of the points.
  KeyframeInput input_by_truth(std::int64_t id) {
    const Observed observed = observe(id, mapping_pose(static_cast<int>(id)), {.to = 100});
    KeyframeInput made;
    made.frame = observed.frame;
    made.reference = 0;
    made.camera_from_reference = mapping_pose(static_cast<int>(id));
    made.points = map.tracked(observed);
    return made;
  }
  bool has(std::size_t point) const { return map.graph.has_landmark(map.landmark_of[point]); }
};

TEST(LandmarkCulling, ALandmarkThatOnlyOneObservesTwoKeyframesLaterIsCulled) {
  LandmarkBench bench;
  bench.process(1);
  EXPECT_TRUE(bench.has(150)) << "one keyframe later";
  bench.process(2);
  for (std::size_t point = 0; point < 200; ++point) EXPECT_EQ(bench.has(point), point < 100) << point;
}

TEST(LandmarkCulling, ALandmarkMustBeFoundInAShareOfTheFramesWhereItIsVisible) {
  LandmarkBench bench;
  const std::int64_t enough = bench.map.landmark_of[0], too_few = bench.map.landmark_of[1];
  // One in four with the frame that created it, and one in five.
  bench.process(1, {enough, enough, enough, too_few, too_few, too_few, too_few});
  EXPECT_TRUE(bench.has(0));
  EXPECT_FALSE(bench.has(1));
}

TEST(LandmarkCulling, AfterThreeKeyframesALandmarkIsKept) {
  LandmarkBench bench;
  bench.process(1);
  bench.process(2);
  const std::int64_t landmark = bench.map.landmark_of[0], other = bench.map.landmark_of[1];
  const std::vector<std::int64_t> often(30, landmark);
  bench.process(3, std::vector<std::int64_t>(30, other));
  EXPECT_FALSE(bench.has(1)) << "it was still on trial";
  bench.map.landmark_of[1] = -1;
  bench.process(4, often);
  EXPECT_TRUE(bench.has(0));
}

}  // namespace
}  // namespace rastro
