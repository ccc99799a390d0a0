// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/live_places.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "rastro/map/semi_dense/semi_dense_layer.h"

namespace rastro::cli {
namespace {

constexpr TimeNs second = 1'000'000'000;

/// Keyframes a second apart, that of row k with id k from frame 10 k.
Map map_of_keyframes(int count) {
  Map map;
  map.cameras.emplace_back();
  for (int k = 0; k < count; ++k) {
    Keyframe keyframe;
    keyframe.id = k;
    keyframe.frame = 10 * k;
    keyframe.stamp = k * second;
    map.keyframes.push_back(keyframe);
  }
  return map;
}

/// Of each keyframe of such a map, with its frame as the only byte.
void see_all(int count, SeenImages& seen) {
  for (int k = 0; k < count; ++k) {
    LiveImage image;
    image.index = 10 * k;
    image.jpeg = {static_cast<std::uint8_t>(10 * k)};
    seen.add(k * second, image);
  }
}

TEST(LivePlaces, ShowALoopClosureOnceWithThePlaceItMatched) {
  Map map = map_of_keyframes(5);
  SeenImages seen;
  see_all(5, seen);
  LivePlaces places;
  EXPECT_EQ(places.of(map, seen), std::nullopt) << "nothing was matched, and no method colors its keyframes";
  map.constraints.push_back({.from = 1, .to = 4, .kind = ConstraintKind::loop});
  map.constraints.push_back({.from = 3, .to = 4, .kind = ConstraintKind::odometry});
  const auto place = places.of(map, seen);
  ASSERT_TRUE(place && place->matched_image);
  EXPECT_EQ(place->keyframe, 4);
  EXPECT_EQ(place->image.index, 40);
  EXPECT_EQ(place->matched, 1);
  EXPECT_EQ(place->matched_image->jpeg, (std::vector<std::uint8_t>{10}));
  EXPECT_EQ(places.of(map, seen), std::nullopt) << "shown already";
}

TEST(LivePlaces, ShowTheFrameThatWasRelocalizedAndWhere) {
  const Map map = map_of_keyframes(3);
  SeenImages seen;
  see_all(9, seen);
  LivePlaces places;
  SlamUpdate update;
  update.stamp = 7 * second;
  update.events.push_back({"relocalized", "in keyframe 1", 1});
  places.note(update);
  const auto place = places.of(map, seen);
  ASSERT_TRUE(place && place->matched_image);
  EXPECT_EQ(place->keyframe, no_keyframe);
  EXPECT_EQ(place->image.index, 70);
  EXPECT_EQ(place->matched_image->index, 10);
}

TEST(LivePlaces, ShowTheNewestDepthsFromBlueToRed) {
  Map map = map_of_keyframes(2);
  auto layer = std::make_shared<SemiDenseLayer>();
  auto depth = std::make_shared<SemiDenseDepth>();
  for (std::uint16_t x = 0; x < 100; ++x)
    depth->pixels.push_back({x, 5, 0.001F + 0.01F * static_cast<float>(x), 1.0F, 9});
  layer->of[1] = depth;
  map.layers.put<SemiDenseLayer>(std::move(layer));
  SeenImages seen;
  see_all(2, seen);
  LivePlaces places;
  const auto place = places.of(map, seen);
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(place->keyframe, 1);
  const LiveFeatures& features = place->image.features;
  ASSERT_EQ(features.colors.size(), 300U);
  EXPECT_GT(features.colors[2], features.colors[0]) << "far: blue";
  EXPECT_GT(features.colors[297], features.colors[299]) << "near: red";
}

TEST(SeenImages, KnowTheNearestInTimeAndNoneOfOtherTimes) {
  SeenImages seen;
  see_all(3, seen);
  EXPECT_EQ(seen.near(second + 100'000'000)->index, 10);
  EXPECT_EQ(seen.near(2 * second - 100'000'000)->index, 20);
  EXPECT_EQ(seen.near(10 * second), std::nullopt);
  LiveImage large;
  large.jpeg.resize(20'000'000);
  seen.add(5 * second, large);
  seen.add(6 * second, large);
  EXPECT_EQ(seen.near(0), std::nullopt) << "given up for memory";
}

}  // namespace
}  // namespace rastro::cli
