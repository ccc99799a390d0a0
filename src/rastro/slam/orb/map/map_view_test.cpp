// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/map_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/math/math_testing.h"
#include "rastro/slam/orb/map/graph_testing.h"

namespace rastro {
namespace {

using testing::add_landmark;
using testing::blank_frame;
using testing::small_camera;
using Ids = std::vector<std::int64_t>;

MapGraph chain(std::int64_t keyframes, CameraKind sensor = CameraKind::mono) {
  MapGraph graph(small_camera(), sensor, sensor == CameraKind::mono ? 0.0 : 0.1, {});
  for (std::int64_t k = 0; k < keyframes; ++k)
    graph.add_keyframe(blank_frame(k), SE3(SO3(), {0.1 * static_cast<double>(k), 0.0, 0.0}), 0, k - 1);
  return graph;
}

/// `count` landmarks that both observe, from feature `begin` on.
void share(MapGraph& graph, std::int64_t a, std::int64_t b, std::uint32_t begin, std::uint32_t count) {
  for (std::uint32_t feature = begin; feature < begin + count; ++feature) add_landmark(graph, feature, {a, b});
}

Ids keyframes_of(const MapView& view) {
  Ids ids;
  for (const MapView::Keyframe& keyframe : view.keyframes) ids.push_back(keyframe.id);
  return ids;
}

Ids keyframes_around(const MapGraph& graph, std::int64_t center, int keyframes) {
  return keyframes_of(*view_of(graph, center, {.keyframes = keyframes, .landmarks = 100}));
}

TEST(MapView, CopiesKeyframesAndLandmarks) {
  MapGraph graph = chain(3);
  graph.keyframe(1).unit = 2.5;
  const std::int64_t first = add_landmark(graph, 0, {0, 1, 2}), second = add_landmark(graph, 1, {1, 2});
  graph.describe(second);
  graph.landmark(second).descriptor.words[0] = 77;
  graph.keyframe(2).submap = 3;
  const auto view = view_of(graph, 1, {});
  graph.remove_landmark(first);
  EXPECT_EQ(view->center, 1);
  EXPECT_EQ(view->latest, 2);
  EXPECT_EQ(keyframes_of(*view), (Ids{0, 1, 2}));
  EXPECT_EQ(view->keyframe(1).unit, 2.5);
  EXPECT_EQ(view->keyframe(2).submap, 3);
  EXPECT_EQ(view->keyframe(2).frame, graph.keyframe(2).frame);
  EXPECT_THAT(view->keyframe(2).camera_from_world, testing::pose_near(graph.camera_from_world(2), 0.0, 0.0));
  ASSERT_EQ(view->ids, (Ids{first, second})) << "a view never changes";
  const MapLandmark& landmark = graph.landmark(second);
  EXPECT_EQ(view->positions[1], landmark.position);
  EXPECT_EQ(view->directions[1], landmark.direction);
  EXPECT_EQ(view->min_distances[1], landmark.min_distance);
  EXPECT_EQ(view->max_distances[1], landmark.max_distance);
  EXPECT_GT(view->max_distances[1], view->min_distances[1]);
  EXPECT_EQ(view->descriptors[1].words[0], 77U);
  EXPECT_EQ(view->seen_begin, (std::vector<std::uint32_t>{0, 3, 5}));
  EXPECT_EQ(view->seen_by, (std::vector<std::uint32_t>{0, 1, 2, 1, 2}));
}

TEST(MapView, FindsItsLandmarksAndKeyframesOnly) {
  MapGraph graph = chain(4);
  share(graph, 1, 3, 0, 3);
  graph.remove_landmark(1);
  const auto view = view_of(graph, 3, {.keyframes = 3, .landmarks = 100});
  EXPECT_EQ(keyframes_of(*view), (Ids{1, 2, 3}));
  EXPECT_EQ(view->find_keyframe(1), 0);
  EXPECT_EQ(view->find_keyframe(3), 2);
  EXPECT_EQ(view->find_keyframe(0), -1);
  EXPECT_EQ(view->find_keyframe(4), -1);
  EXPECT_EQ(view->find(0), 0);
  EXPECT_EQ(view->find(1), -1);
  EXPECT_EQ(view->find(2), 1);
  EXPECT_EQ(view->find(3), -1);
}

/// Keyframes are read until they have more than four times as many landmarks as the view may hold; the newest are kept.
TEST(MapView, OfTooManyLandmarksTheNewestOfTheNearestKeyframesAreKept) {
  MapGraph graph = chain(2);
  share(graph, 0, 1, 0, 8);
  const std::int64_t newest = add_landmark(graph, 20, {1});
  EXPECT_EQ(view_of(graph, 0, {.keyframes = 2, .landmarks = 2})->ids, (Ids{newest - 1, newest}));
  EXPECT_EQ(view_of(graph, 0, {.keyframes = 2, .landmarks = 1})->ids, (Ids{newest - 1})) << "eight are enough";
}

TEST(MapView, TakesNeighborsThenTheirsThatShareEnoughMostFirst) {
  MapGraph graph = chain(6);
  for (const std::int64_t id : {3, 4, 5}) graph.set_parent(id, 0);
  share(graph, 2, 3, 0, 1);   // one is enough for a neighbor of the center
  share(graph, 3, 4, 1, 15);  // just enough for a neighbor's neighbor
  share(graph, 3, 5, 16, 14);
  EXPECT_EQ(keyframes_around(graph, 2, 40), (Ids{0, 1, 2, 3, 4})) << "and parents, whatever they share";
  EXPECT_EQ(keyframes_around(graph, 2, 3), (Ids{1, 2, 3}));
  EXPECT_EQ(keyframes_around(graph, 2, 2), (Ids{2, 3}));
  EXPECT_EQ(keyframes_around(graph, 3, 3), (Ids{3, 4, 5})) << "two and three share less";
}

TEST(MapView, TakesTenOfANeighborsNeighbors) {
  MapGraph graph = chain(14);
  for (std::int64_t id = 2; id < 14; ++id) graph.set_parent(id, 0);
  share(graph, 0, 1, 0, 1);
  // Twelve keyframes share 16 landmarks with keyframe 1, of which the first two share one less.
  for (std::uint32_t feature = 1; feature < 17; ++feature) {
    Ids observers{1};
    for (std::int64_t id = feature == 1 ? 4 : 2; id < 14; ++id) observers.push_back(id);
    add_landmark(graph, feature, observers);
  }
  EXPECT_EQ(keyframes_around(graph, 0, 40), (Ids{0, 1, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13}));
}

TEST(MapView, LandmarksOfAKeyframeCountIfEnoughKeyframesObserveThem) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::depth}) {
    const int depth = sensor == CameraKind::mono ? 0 : 1;
    MapGraph three = chain(3, sensor);
    for (std::uint32_t f = 0; f < 5; ++f) add_landmark(three, f, {0, 1, 2});
    for (std::uint32_t f = 5; f < 12; ++f) add_landmark(three, f, {0, 1});
    for (std::uint32_t f = 12; f < 25; ++f) add_landmark(three, f, {0});
    EXPECT_EQ(view_of(three, 0, {})->keyframe(0).landmarks, 5 + 7 * depth);
    MapGraph two = chain(2, sensor);
    for (std::uint32_t f = 5; f < 12; ++f) add_landmark(two, f, {0, 1});
    for (std::uint32_t f = 12; f < 25; ++f) add_landmark(two, f, {0});
    EXPECT_EQ(view_of(two, 0, {})->keyframe(0).landmarks, 7 + 13 * depth);
  }
}

TEST(MapView, OfTooManyLandmarksTheNewestStay) {
  MapGraph graph = chain(3);
  share(graph, 0, 1, 0, 10);
  share(graph, 1, 2, 10, 10);
  const auto view = view_of(graph, 1, {.keyframes = 40, .landmarks = 8});
  EXPECT_EQ(view->ids, (Ids{12, 13, 14, 15, 16, 17, 18, 19}));
  EXPECT_EQ(view_of(graph, 1, {.keyframes = 40, .landmarks = 20})->size(), 20U);
  EXPECT_EQ(view_of(graph, 1, {.keyframes = 40, .landmarks = 19})->ids.front(), 1);
}

TEST(MapView, NoMoreKeyframesAreReadOnceThereAreFourTimesTooManyLandmarks) {
  MapGraph graph = chain(3);
  for (std::uint32_t f = 0; f < 8; ++f) add_landmark(graph, f, {1});
  share(graph, 0, 1, 8, 1);
  add_landmark(graph, 30, {0});  // the newest, of the neighbor
  const auto newest = [&](int landmarks) {
    return view_of(graph, 1, {.keyframes = 40, .landmarks = landmarks})->ids.back();
  };
  EXPECT_EQ(newest(3), 9) << "nine are not too many of three";
  EXPECT_EQ(newest(2), 8) << "of two they are";
}

}  // namespace
}  // namespace rastro
