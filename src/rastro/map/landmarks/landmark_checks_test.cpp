// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmark/landmark_checks.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "rastro/map/landmark/keyframe_places.h"
#include "rastro/map/landmark/landmark_map_testing.h"

namespace rastro {
namespace {

constexpr std::int64_t no_id = 999'999;

/// A keyframe of the map, to be changed.
LandmarkKeyframe& keyframe(LandmarkMap& map, std::size_t k) {
  auto own = std::make_shared<LandmarkKeyframe>(*map.keyframes[k]);
  map.keyframes[k] = own;
  return *own;
}

TEST(LandmarkChecks, ASoundMapOfEverySensorPasses) {
  for (const LandmarkSensor sensor : {LandmarkSensor::mono, LandmarkSensor::stereo, LandmarkSensor::rgbd}) {
    TestRoad road;
    road.sensor = sensor;
    EXPECT_EQ(contradiction_in(make_landmark_test_map(road)), "");
  }
  EXPECT_EQ(contradiction_in(LandmarkMap()), "") << "nothing contradicts nothing";
}

/// A way to damage a map, and a word of what must be said of it.
struct Damage {
  const char* word;
  std::function<void(LandmarkMap&)> by;
};

const std::vector<Damage>& damages() {
  static const std::vector<Damage> all = {
      {"pose", [](LandmarkMap& map) { map.poses.pop_back(); }},
      {"lacks", [](LandmarkMap& map) { map.keyframes[3] = nullptr; }},
      {"order", [](LandmarkMap& map) { std::swap(map.keyframes[2], map.keyframes[3]); }},
      {"order", [](LandmarkMap& map) { keyframe(map, 2).id = map.keyframes[1]->id; }},
      {"order", [](LandmarkMap& map) { keyframe(map, 0).id = -1; }},
      {"described", [](LandmarkMap& map) { keyframe(map, 1).features.descriptors.pop_back(); }},
      {"described", [](LandmarkMap& map) { keyframe(map, 1).features.levels.pop_back(); }},
      {"depths", [](LandmarkMap& map) { keyframe(map, 4).depths.pop_back(); }},
      {"depths", [](LandmarkMap& map) { keyframe(map, 4).right_x.push_back(1.0F); }},
      {"level", [](LandmarkMap& map) { keyframe(map, 5).features.levels[0] = 200; }},
      {"not there", [](LandmarkMap& map) { map.poses[4].parent = no_id; }},
      {"ring", [](LandmarkMap& map) { map.poses[0].parent = map.keyframes.back()->id; }},
      {"ring", [](LandmarkMap& map) { map.poses[6].parent = map.keyframes[6]->id; }},
      {"order", [](LandmarkMap& map) { std::swap(map.landmarks[7], map.landmarks[8]); }},
      {"order", [](LandmarkMap& map) { map.landmarks[0].id = -4; }},
      {"place", [](LandmarkMap& map) { map.landmarks[9].position.y() = std::numeric_limits<double>::quiet_NaN(); }},
      {"place", [](LandmarkMap& map) { map.landmarks[9].direction.x() = std::numeric_limits<double>::infinity(); }},
      {"keyframe that is not there", [](LandmarkMap& map) { map.landmarks[5].observations.back().keyframe = no_id; }},
      {"keyframe that is not there",
       [](LandmarkMap& map) {
         auto& seen = map.landmarks[5].observations;
         seen.push_back(seen.back());  // by one keyframe twice
       }},
      {"feature that is not there", [](LandmarkMap& map) { map.landmarks[5].observations[0].feature = 100'000; }},
      {"tie", [](LandmarkMap& map) { map.ties[0].from = no_id; }},
      {"tie", [](LandmarkMap& map) { map.ties[0].to = no_id; }},
  };
  return all;
}

TEST(LandmarkChecks, EveryDamageIsSaid) {
  TestRoad road;
  road.sensor = LandmarkSensor::stereo;
  const LandmarkMap sound = make_landmark_test_map(road);
  for (std::size_t k = 0; k < damages().size(); ++k) {
    LandmarkMap map = sound;
    damages()[k].by(map);
    const std::string said = contradiction_in(map);
    EXPECT_NE(said.find(damages()[k].word), std::string::npos) << k << ": '" << said << "'";
  }
  EXPECT_EQ(contradiction_in(sound), "");
}

TEST(LandmarkChecks, SeveralRootsAreSeveralSubmaps) {
  LandmarkMap map = make_landmark_test_map();
  map.poses[5].parent = -1;
  map.poses[9].parent = -1;
  EXPECT_EQ(contradiction_in(map), "");
}

TEST(KeyframePlaces, FindIdsAmongGaps) {
  const LandmarkMap map = make_landmark_test_map();
  const KeyframePlaces places(map);
  std::size_t found = 0;
  for (std::int64_t id = -2; id < 30; ++id) {
    std::optional<std::size_t> expected;
    for (std::size_t k = 0; k < map.keyframes.size(); ++k)
      if (map.keyframes[k]->id == id) expected = k;
    EXPECT_EQ(places.of(id), expected) << id;
    found += expected ? 1 : 0;
  }
  EXPECT_EQ(found, map.keyframes.size());
}

}  // namespace
}  // namespace rastro
