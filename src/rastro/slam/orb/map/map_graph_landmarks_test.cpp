// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/random.h"
#include "rastro/feature/hamming.h"
#include "rastro/slam/orb/map/graph_testing.h"

namespace rastro {
namespace {

using testing::add_landmark;
using testing::blank_frame;
using testing::feature_count;
using testing::small_camera;

/// Frame `id` with random descriptors and levels.
std::shared_ptr<const FeatureFrame> random_frame(std::int64_t id, Random& random) {
  auto data = std::make_shared<ImageFeatures>(blank_frame(id)->data());
  for (std::uint32_t i = 0; i < feature_count; ++i) {
    data->features.levels[i] = static_cast<std::uint8_t>(random.below(8));
    for (auto& word : data->features.descriptors[i].words) word = random.next();
  }
  return std::make_shared<FeatureFrame>(std::move(data), small_camera(), 0.0);
}

/// Keyframes along a curve, facing forward, and landmark k at feature k of the last `2 + k % 5` of them.
struct CurvedGraph {
  static constexpr int keyframes = 7, landmarks = 30;
  MapGraph graph{small_camera(), CameraKind::mono, 0.0, {}};

  explicit CurvedGraph(std::uint64_t seed) {
    Random random(seed);
    for (int k = 0; k < keyframes; ++k) {
      const SE3 pose(SO3::exp({0.0, 0.05 * k, 0.02 * k}), {-0.3 * k, 0.02 * k, 0.1 * k});
      graph.add_keyframe(random_frame(k, random), pose, 0, k - 1);
    }
    for (int l = 0; l < landmarks; ++l) {
      const int first = keyframes - 2 - l % 5;
      const Eigen::Vector3d position(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(3.0, 9.0));
      // Every third was created by a keyframe that does not observe it any more.
      const std::int64_t id = graph.add_landmark(position, l % 3 == 0 ? 0 : first + 1).id;
      for (int k = first; k < keyframes; ++k) graph.add_observation(k, static_cast<std::uint32_t>(l), id);
    }
  }
};

/// The sum of distances to the middle one, counted from the nearest; with an even number, to the lower of the two.
int middle_distance(const Descriptor& from, const std::vector<Descriptor>& to) {
  std::vector<int> distances;
  for (const Descriptor& other : to) distances.push_back(hamming_distance(from, other));
  std::sort(distances.begin(), distances.end());
  return distances[(distances.size() - 1) / 2];
}

TEST(MapGraph, ALandmarksDescriptorIsTheOneWithTheLeastMedianDistance) {
  CurvedGraph curved(3);
  for (const std::int64_t id : curved.graph.landmark_ids()) {
    curved.graph.describe(id);
    const MapLandmark& landmark = curved.graph.landmark(id);
    std::vector<Descriptor> all;
    for (const LandmarkObservation& o : landmark.observations)
      all.push_back(curved.graph.keyframe(o.keyframe).frame->descriptor(o.feature));
    int least = 257;
    for (const Descriptor& descriptor : all) least = std::min(least, middle_distance(descriptor, all));
    const auto first = std::find_if(all.begin(), all.end(), [&](const Descriptor& descriptor) {
      return middle_distance(descriptor, all) == least;
    });
    EXPECT_EQ(landmark.descriptor, *first) << id << " the first of several";
  }
}

TEST(MapGraph, ALandmarksDirectionIsTheMeanOfTheViewsAndItsDistancesAreOfItsFirstKeyframe) {
  CurvedGraph curved(5);
  for (const std::int64_t id : curved.graph.landmark_ids()) {
    curved.graph.describe(id);
    const MapLandmark& landmark = curved.graph.landmark(id);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const LandmarkObservation& o : landmark.observations) {
      const Eigen::Vector3d center = curved.graph.keyframe(o.keyframe).camera_from_world.inverse().translation();
      sum += (landmark.position - center).normalized();
    }
    EXPECT_LT((landmark.direction - sum.normalized()).norm(), 1e-12) << id;
    const auto creator = std::find_if(landmark.observations.begin(), landmark.observations.end(),
                                      [&](const auto& o) { return o.keyframe == landmark.first_keyframe; });
    const LandmarkObservation& from = creator != landmark.observations.end() ? *creator : landmark.observations.front();
    const MapKeyframe& keyframe = curved.graph.keyframe(from.keyframe);
    const double distance = (keyframe.camera_from_world * landmark.position).norm();
    const double scale = std::pow(1.2, keyframe.frame->level(from.feature));
    EXPECT_NEAR(landmark.max_distance, distance * scale, 1e-5) << id;
    EXPECT_NEAR(landmark.min_distance, distance * scale / std::pow(1.2, 7), 1e-5) << id;
  }
}

TEST(MapGraph, FusedLandmarksHaveTheObservationsAndCountsOfBoth) {
  MapGraph graph(small_camera(), CameraKind::mono, 0.0, {});
  for (int k = 0; k < 5; ++k) graph.add_keyframe(blank_frame(k), SE3(SO3(), {-0.1 * k, 0.0, 0.0}), 0, k - 1);
  const std::int64_t kept = add_landmark(graph, 1, {0, 1, 2}), gone = add_landmark(graph, 2, {2, 3, 4});
  graph.landmark(kept).visible = 7, graph.landmark(kept).found = 5;
  graph.landmark(gone).visible = 20, graph.landmark(gone).found = 11;
  graph.fuse(kept, kept);
  EXPECT_TRUE(graph.has_landmark(kept));
  graph.fuse(kept, gone);
  EXPECT_FALSE(graph.has_landmark(gone));
  EXPECT_EQ(graph.current(gone), kept);
  EXPECT_EQ(graph.landmark(kept).visible, 27);
  EXPECT_EQ(graph.landmark(kept).found, 16);
  using Observations = std::vector<LandmarkObservation>;
  EXPECT_EQ(graph.landmark(kept).observations, (Observations{{0, 1}, {1, 1}, {2, 1}, {3, 2}, {4, 2}}));
  EXPECT_EQ(graph.keyframe(2).landmarks[2], -1) << "one of the two features observes it";
  EXPECT_EQ(graph.feature_of(4, kept), 2);
  EXPECT_EQ(graph.shared(0, 4), 1);
  EXPECT_EQ(graph.landmark_ids(), std::vector<std::int64_t>{kept});
}

/// Memory does not grow with what was fused long ago.
TEST(MapGraph, TheLastSixteenThousandFusionsAreFollowedAndThoseOfLongAgoForgotten) {
  MapGraph graph(small_camera(), CameraKind::mono, 0.0, {});
  graph.add_keyframe(blank_frame(0), SE3(), 0, -1);
  const std::int64_t kept = add_landmark(graph, 1, {0});
  std::vector<std::int64_t> gone;
  for (int i = 0; i < 32001; ++i) {
    gone.push_back(graph.add_landmark({0.0, 0.0, 1.0}, 0).id);
    graph.fuse(kept, gone.back());
  }
  EXPECT_EQ(graph.current(gone[0]), -1);
  EXPECT_EQ(graph.current(gone[gone.size() - 16000]), kept);
  EXPECT_EQ(graph.current(gone.back()), kept);
  EXPECT_EQ(graph.landmark_count(), 1U);
  EXPECT_EQ(graph.current(kept), kept);
}

TEST(MapGraph, AnObservationIsAddedOnceAndRemovedOnce) {
  MapGraph graph(small_camera(), CameraKind::mono, 0.0, {});
  for (int k = 0; k < 3; ++k) graph.add_keyframe(blank_frame(k), SE3(SO3(), {-0.1 * k, 0.0, 0.0}), 0, k - 1);
  const std::int64_t one = add_landmark(graph, 1, {0, 2}), other = add_landmark(graph, 3, {2});
  graph.add_observation(2, 5, one);
  EXPECT_EQ(graph.feature_of(2, one), 1) << "the keyframe observes it already";
  graph.add_observation(2, 1, other);
  EXPECT_EQ(graph.keyframe(2).landmarks[1], one) << "the feature has a landmark";
  graph.remove_observation(1, one);
  EXPECT_EQ(graph.landmark(one).observations.size(), 2U);
  graph.remove_observation(0, one);
  EXPECT_EQ(graph.feature_of(0, one), -1);
  EXPECT_EQ(graph.keyframe(0).landmarks[1], -1);
  EXPECT_EQ(graph.shared(0, 2), 0);
  EXPECT_TRUE(graph.keyframe(0).neighbors.empty());
  EXPECT_EQ(graph.feature_of(2, one), 1);
}

}  // namespace
}  // namespace rastro
