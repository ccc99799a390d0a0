// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "rastro/map/images/pack_images.h"
#include "rastro/map/landmarks/landmark_map_testing.h"

namespace rastro {
namespace {

constexpr KeyframeId no_id = 999'999;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Changes a copy of the layer.
template <typename L>
void change(Map& map, const std::function<void(L&)>& by) {
  auto own = std::make_shared<L>(*map.layer<L>());
  by(*own);
  map.layers.put<L>(std::move(own));
}

/// Changes the features of the k-th keyframe.
void change_features(Map& map, std::size_t k, const std::function<void(ImageFeatures&)>& by) {
  change<FeatureLayer>(map, [&](FeatureLayer& layer) {
    auto own = std::make_shared<ImageFeatures>(*layer.of.at(map.keyframes[k].id));
    by(*own);
    layer.of.at(map.keyframes[k].id) = own;
  });
}

void change_landmark(Map& map, std::size_t i, const std::function<void(Landmark&)>& by) {
  change<LandmarkLayer>(map, [&](LandmarkLayer& layer) { by(layer.landmarks[i]); });
}

TEST(LandmarkChecks, ASoundMapOfEverySensorPasses) {
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::stereo, CameraKind::depth}) {
    TestRoad road;
    road.sensor = sensor;
    EXPECT_EQ(contradiction_in(make_landmark_test_map(road)), "");
  }
  EXPECT_EQ(contradiction_in(Map()), "") << "nothing contradicts nothing";
}

/// A kind of damage to a map, and words of the expected message.
struct Damage {
  const char* words;
  std::function<void(Map&)> by;
};

const std::vector<Damage>& damages_of_keyframes() {
  static const std::vector<Damage> all = {
      {"keyframes out of order", [](Map& map) { std::swap(map.keyframes[2], map.keyframes[3]); }},
      {"keyframes out of order", [](Map& map) { map.keyframes[2].id = map.keyframes[1].id; }},
      {"keyframes out of order", [](Map& map) { map.keyframes[0].id = -1; }},
      {"without a pose",
       [](Map& map) {
         map.keyframes[3].world_from_camera = SE3(SO3(), {0.0, not_a_number, 0.0});
       }},
      {"camera that is not there", [](Map& map) { map.keyframes[3].camera = 1; }},
      {"camera that is not there", [](Map& map) { map.keyframes[3].camera = -1; }},
      {"submap that cannot be", [](Map& map) { map.keyframes[3].submap = -1; }},
      {"leads to a keyframe that is not there", [](Map& map) { map.keyframes[4].parent = no_id; }},
      {"ring", [](Map& map) { map.keyframes[0].parent = map.keyframes.back().id; }},
      {"ring", [](Map& map) { map.keyframes[6].parent = map.keyframes[6].id; }},
      {"constraint to a keyframe", [](Map& map) { map.constraints[0].from = no_id; }},
      {"constraint to a keyframe", [](Map& map) { map.constraints[0].to = no_id; }},
      {"frame relative to a keyframe", [](Map& map) { map.frames[5].keyframe = no_id; }},
  };
  return all;
}

const std::vector<Damage>& damages_of_layers() {
  static const std::vector<Damage> all = {
      {"not all described",
       [](Map& map) { change_features(map, 1, [](auto& image) { image.features.descriptors.pop_back(); }); }},
      {"not all described",
       [](Map& map) { change_features(map, 1, [](auto& image) { image.features.levels.pop_back(); }); }},
      {"depths for some", [](Map& map) { change_features(map, 4, [](auto& image) { image.depths.pop_back(); }); }},
      {"depths for some",
       [](Map& map) { change_features(map, 4, [](auto& image) { image.right_x.push_back(1.0F); }); }},
      {"level", [](Map& map) { change_features(map, 5, [](auto& image) { image.features.levels[0] = 200; }); }},
      {"has features of a keyframe that is not there",
       [](Map& map) { change<FeatureLayer>(map, [](auto& layer) { layer.of[no_id] = layer.of.begin()->second; }); }},
      {"has images of a keyframe that is not there",
       [](Map& map) {
         auto images = std::make_shared<ImageLayer>();
         images->keyframes = {0, no_id};
         images->store = std::make_shared<MemoryImages>();
         map.layers.put<ImageLayer>(std::move(images));
       }},
      {"landmarks out of order",
       [](Map& map) {
         change<LandmarkLayer>(map, [](auto& layer) { std::swap(layer.landmarks[7], layer.landmarks[8]); });
       }},
      {"landmarks out of order", [](Map& map) { change_landmark(map, 0, [](auto& landmark) { landmark.id = -4; }); }},
      {"without a position",
       [](Map& map) { change_landmark(map, 9, [](auto& landmark) { landmark.position.y() = not_a_number; }); }},
      {"without a position",
       [](Map& map) {
         change_landmark(map, 9,
                         [](auto& landmark) { landmark.direction.x() = std::numeric_limits<double>::infinity(); });
       }},
      {"keyframe or feature that is not there",
       [](Map& map) {
         change_landmark(map, 5, [](auto& landmark) { landmark.observations.back().keyframe = no_id; });
       }},
      {"keyframe or feature that is not there",
       [](Map& map) { change_landmark(map, 5, [](auto& landmark) { landmark.observations[0].feature = 100'000; }); }},
      {"observations are out of order",
       [](Map& map) {
         change_landmark(map, 5, [](auto& landmark) {
           const LandmarkObservation twice = landmark.observations.back();
           landmark.observations.push_back(twice);
         });
       }},
      {"without an estimate",
       [](Map& map) { change<LandmarkLayer>(map, [](auto& layer) { layer.estimates.resize(1); }); }},
  };
  return all;
}

TEST(LandmarkChecks, EveryDamageIsReported) {
  TestRoad road;
  road.sensor = CameraKind::stereo;
  const Map sound = make_landmark_test_map(road);
  for (const auto* damages : {&damages_of_keyframes(), &damages_of_layers()}) {
    for (std::size_t k = 0; k < damages->size(); ++k) {
      Map map = sound;
      (*damages)[k].by(map);
      const std::string said = contradiction_in(map);
      EXPECT_NE(said.find((*damages)[k].words), std::string::npos) << k << ": '" << said << "'";
    }
  }
  EXPECT_EQ(contradiction_in(sound), "");
}

TEST(LandmarkChecks, SeveralRootsAreSeveralSubmaps) {
  Map map = make_landmark_test_map();
  map.keyframes[5].parent = no_keyframe;
  map.keyframes[9].parent = no_keyframe;
  EXPECT_EQ(contradiction_in(map), "");
}

TEST(LandmarkChecks, AMapWithoutFeaturesCannotMissOne) {
  Map map = make_landmark_test_map();
  map.layers.put<FeatureLayer>(nullptr);
  EXPECT_EQ(contradiction_in(map), "");
}

}  // namespace
}  // namespace rastro
