// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmarks/landmark_layer.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "rastro/base/error.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"

namespace rastro {
namespace {

const LayerType& landmarks_type() { return *layer_type(LandmarkLayer::layer_name); }

/// Two keyframes, 1 and 4, without features, and landmarks 2, 5 and 9 that they observe.
Map small_map() {
  Map map;
  for (const KeyframeId id : {1, 4}) {
    Keyframe& keyframe = map.keyframes.emplace_back();
    keyframe.id = id;
    keyframe.submap = id == 4 ? 1 : 0;
  }
  auto layer = std::make_shared<LandmarkLayer>();
  for (const std::int64_t id : {2, 5, 9}) {
    Landmark& landmark = layer->landmarks.emplace_back();
    const auto value = static_cast<double>(id);
    landmark.id = id;
    landmark.position = {value, 0.25 * value, 7.0};
    landmark.direction = {0.0, 0.6, 0.8};
    landmark.descriptor.words = {static_cast<std::uint64_t>(id), 2, 3, 4};
    landmark.min_distance = 0.5F, landmark.max_distance = 20.0F;
  }
  layer->landmarks[0].observations = {{1, 7}, {4, 3}};
  layer->landmarks[1].observations = {{4, 8}};
  layer->landmarks[2].observations = {{1, 9}};
  map.layers.put<LandmarkLayer>(std::move(layer));
  return map;
}

LandmarkLayer layer_of(const Map& map) { return *map.layer<LandmarkLayer>(); }

void add_estimates(LandmarkLayer& layer) {
  for (std::size_t i = 0; i < layer.landmarks.size(); ++i) {
    LandmarkEstimate& estimate = layer.estimates.emplace_back();
    estimate.sensor_id = static_cast<std::int64_t>(i) - 1;
    estimate.observations = 4 + static_cast<int>(i);
    estimate.covariance << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  }
}

TEST(LandmarkLayer, FindsByIdBeforeBetweenAndBehindItsRows) {
  const LandmarkLayer layer = layer_of(small_map());
  for (std::int64_t id = 0; id <= 12; ++id) {
    const Landmark* expected = nullptr;
    for (const Landmark& landmark : layer.landmarks)
      if (landmark.id == id) expected = &landmark;
    EXPECT_EQ(layer.find(id), expected) << id;
  }
  EXPECT_FALSE(LandmarkLayer().find(0));
  // Past the last row nothing may be read, whatever is in memory there.
  LandmarkLayer shrunk = layer;
  shrunk.landmarks.pop_back();
  EXPECT_FALSE(shrunk.find(9));
  EXPECT_EQ(shrunk.find(5), &shrunk.landmarks[1]);
}

TEST(LandmarkLayer, ARowReadsBackAsItWas) {
  const Map map = small_map();
  for (const bool estimated : {false, true}) {
    LandmarkLayer layer = layer_of(map);
    if (estimated) add_estimates(layer);
    const auto again = std::static_pointer_cast<LandmarkLayer>(landmarks_type().make("", "here"));
    for (const std::int64_t id : landmarks_type().rows(layer))
      landmarks_type().read(*again, id, landmarks_type().row(layer, id), "here");
    ASSERT_EQ(again->landmarks.size(), 3U);
    ASSERT_EQ(again->estimates.size(), layer.estimates.size());
    for (std::size_t i = 0; i < 3; ++i) {
      const Landmark &before = layer.landmarks[i], &now = again->landmarks[i];
      EXPECT_EQ(now.id, before.id);
      EXPECT_EQ(now.position, before.position);
      EXPECT_EQ(now.direction, before.direction);
      EXPECT_EQ(now.descriptor, before.descriptor);
      EXPECT_EQ(now.min_distance, before.min_distance);
      EXPECT_EQ(now.max_distance, before.max_distance);
      EXPECT_EQ(now.observations, before.observations);
      if (!estimated) continue;
      EXPECT_EQ(again->estimates[i].sensor_id, layer.estimates[i].sensor_id);
      EXPECT_EQ(again->estimates[i].observations, layer.estimates[i].observations);
      EXPECT_EQ(again->estimates[i].covariance, layer.estimates[i].covariance);
    }
  }
}

TEST(LandmarkLayer, RefusesRowsOfWhichOnlySomeHaveEstimates) {
  LandmarkLayer plain = layer_of(small_map()), estimated = plain;
  add_estimates(estimated);
  const std::string without = landmarks_type().row(plain, 2), with = landmarks_type().row(estimated, 5);
  for (const bool swapped : {false, true}) {
    const auto layer = landmarks_type().make("", "here");
    landmarks_type().read(*layer, 2, swapped ? with : without, "here");
    EXPECT_THROW(landmarks_type().read(*layer, 5, swapped ? without : with, "here"), Error);
  }
  std::string neither = without;
  neither.back() = 2;
  EXPECT_THROW(landmarks_type().read(*landmarks_type().make("", "here"), 2, neither, "here"), Error);
}

TEST(LandmarkLayer, RefusesObservationsOutOfOrder) {
  for (const KeyframeId second : {1, 0}) {
    LandmarkLayer layer = layer_of(small_map());
    layer.landmarks[0].observations[1].keyframe = second;
    EXPECT_THROW(landmarks_type().read(*landmarks_type().make("", "here"), 2, landmarks_type().row(layer, 2), "here"),
                 Error)
        << second;
  }
}

TEST(LandmarkLayer, ARowIsTheSameOnlyWhenNothingOfItChanged) {
  const LandmarkLayer before = layer_of(small_map());
  EXPECT_TRUE(landmarks_type().same_row(before, before, 2));
  const std::function<void(Landmark&)> changes[] = {
      [](Landmark& landmark) { landmark.position.z() += 1e-9; },
      [](Landmark& landmark) { landmark.direction.x() = 0.1; },
      [](Landmark& landmark) { landmark.descriptor.words[3] ^= 1; },
      [](Landmark& landmark) { landmark.min_distance = 0.6F; },
      [](Landmark& landmark) { landmark.max_distance = 21.0F; },
      [](Landmark& landmark) { landmark.observations[1].feature = 4; },
      [](Landmark& landmark) { landmark.observations.pop_back(); },
  };
  for (const auto& change : changes) {
    LandmarkLayer now = before;
    change(now.landmarks[0]);
    EXPECT_FALSE(landmarks_type().same_row(before, now, 2));
    EXPECT_TRUE(landmarks_type().same_row(before, now, 5)) << "another row";
  }
  LandmarkLayer estimated = before;
  add_estimates(estimated);
  EXPECT_FALSE(landmarks_type().same_row(before, estimated, 2));
  EXPECT_TRUE(landmarks_type().same_row(estimated, estimated, 2));
  const std::function<void(LandmarkEstimate&)> other_estimates[] = {
      [](LandmarkEstimate& estimate) { estimate.sensor_id = 77; },
      [](LandmarkEstimate& estimate) { ++estimate.observations; },
      [](LandmarkEstimate& estimate) { estimate.covariance(2, 2) *= 2.0; },
  };
  for (const auto& change : other_estimates) {
    LandmarkLayer now = estimated;
    change(now.estimates[0]);
    EXPECT_FALSE(landmarks_type().same_row(estimated, now, 2));
    EXPECT_TRUE(landmarks_type().same_row(estimated, now, 5));
  }
}

TEST(LandmarkLayer, RepairKeepsValidObservations) {
  Map map = small_map();
  auto damaged = std::make_shared<LandmarkLayer>(layer_of(map));
  damaged->landmarks[0].observations.push_back({99, 0});
  damaged->landmarks[1].observations = {{98, 0}};
  auto kept = std::static_pointer_cast<const LandmarkLayer>(landmarks_type().repaired(map, damaged));
  ASSERT_EQ(kept->landmarks.size(), 2U) << "5 is observed by nobody";
  EXPECT_EQ(kept->landmarks[0].id, 2);
  EXPECT_EQ(kept->landmarks[0].observations.size(), 2U);
  EXPECT_EQ(kept->landmarks[1].id, 9);
  damaged->landmarks[2].position.x() = std::numeric_limits<double>::quiet_NaN();
  kept = std::static_pointer_cast<const LandmarkLayer>(landmarks_type().repaired(map, damaged));
  ASSERT_EQ(kept->landmarks.size(), 1U) << "9 has no position";
  EXPECT_EQ(kept->landmarks[0].id, 2);
  damaged->landmarks[0].direction.x() = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(
      std::static_pointer_cast<const LandmarkLayer>(landmarks_type().repaired(map, damaged))->landmarks.empty());
}

TEST(LandmarkLayer, RepairKeepsLandmarksOfAFilterWithTheirEstimates) {
  const Map map = small_map();
  auto damaged = std::make_shared<LandmarkLayer>(layer_of(map));
  for (Landmark& landmark : damaged->landmarks) landmark.observations.clear();
  add_estimates(*damaged);
  damaged->landmarks[0].position.x() = std::numeric_limits<double>::quiet_NaN();
  const auto kept = std::static_pointer_cast<const LandmarkLayer>(landmarks_type().repaired(map, damaged));
  ASSERT_EQ(kept->landmarks.size(), 2U);
  ASSERT_EQ(kept->estimates.size(), 2U);
  EXPECT_EQ(kept->landmarks[0].id, 5);
  EXPECT_EQ(kept->estimates[0].sensor_id, 0);
  EXPECT_EQ(kept->estimates[1].sensor_id, 1);
}

TEST(LandmarkLayer, DescribesTheNumberOfLandmarksAndObservations) {
  const Map map = small_map();
  LayerDescription said = landmarks_type().describe(map, layer_of(map));
  EXPECT_EQ(said.text, "3 landmarks, observed 1.3 times each");
  EXPECT_DOUBLE_EQ(said.numbers.at(1).second, 4.0 / 3.0);
  LandmarkLayer filtered = layer_of(map);
  for (Landmark& landmark : filtered.landmarks) landmark.observations.clear();
  add_estimates(filtered);
  EXPECT_DOUBLE_EQ(landmarks_type().describe(map, filtered).numbers.at(1).second, 5.0);
  said = landmarks_type().describe(map, LandmarkLayer());
  EXPECT_EQ(said.text, "0 landmarks, observed 0.0 times each");
  EXPECT_EQ(said.numbers.at(0).second, 0.0);
}

TEST(LandmarkLayer, ItsPointsAreThoseOfTheSubmapAskedFor) {
  const Map map = small_map();
  const auto xs = [&](int submap) {
    PointCloud cloud;
    landmarks_type().add_points(map, layer_of(map), submap, 1, cloud);
    std::vector<float> all;
    for (const CloudPoint& point : cloud.points) all.push_back(point.position.x());
    return all;
  };
  EXPECT_EQ(xs(-1), (std::vector<float>{2.0F, 5.0F, 9.0F}));
  EXPECT_EQ(xs(0), (std::vector<float>{2.0F, 9.0F}));
  EXPECT_EQ(xs(1), std::vector<float>{5.0F});
  EXPECT_TRUE(xs(2).empty());
}

TEST(LandmarkLayer, APointFacesItsCamerasWithTheSigmaAlongThem) {
  const Map map = make_landmark_test_map();
  PointCloud cloud;
  landmarks_type().add_points(map, layer_of(map), 0, 1, cloud);
  const LandmarkLayer layer = layer_of(map);
  ASSERT_EQ(cloud.points.size(), layer.landmarks.size());
  int with_sigma = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Landmark& landmark = layer.landmarks[i];
    const CloudPoint& point = cloud.points[i];
    EXPECT_EQ(point.position, landmark.position.cast<float>());
    EXPECT_EQ(point.normal, -landmark.direction.cast<float>());
    EXPECT_EQ(point.count, landmark.observations.size());
    const auto covariance = landmark_covariance(map, landmark);
    const double variance = covariance ? landmark.direction.dot(*covariance * landmark.direction) : 0.0;
    EXPECT_FLOAT_EQ(point.sigma, static_cast<float>(std::sqrt(variance)));
    with_sigma += point.sigma > 0.0F ? 1 : 0;
  }
  EXPECT_GT(with_sigma, 100);
}

TEST(LandmarkLayer, AKeyframeIsCutOutAndPastedInAgain) {
  const LandmarkLayer before = layer_of(small_map());
  const LayerCut cut = landmarks_type().cut(before, 1);
  const auto& rest = static_cast<const LandmarkLayer&>(*cut.rest);
  EXPECT_EQ(rest.landmarks[0].observations, (std::vector<LandmarkObservation>{{4, 3}}));
  EXPECT_EQ(rest.landmarks[1].observations, before.landmarks[1].observations);
  EXPECT_TRUE(rest.landmarks[2].observations.empty());
  EXPECT_TRUE(landmarks_type().cut(before, 3).bytes.empty()) << "no landmark is observed by it";
  const auto whole = std::static_pointer_cast<const LandmarkLayer>(landmarks_type().paste(rest, 1, cut.bytes));
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(whole->landmarks[i].observations, before.landmarks[i].observations) << i;
  LandmarkLayer fewer = rest;
  fewer.landmarks.pop_back();  // 9, the last one with observations, was removed meanwhile
  const auto without = std::static_pointer_cast<const LandmarkLayer>(landmarks_type().paste(fewer, 1, cut.bytes));
  ASSERT_EQ(without->landmarks.size(), 2U);
  EXPECT_EQ(without->landmarks[0].observations, before.landmarks[0].observations);
  LandmarkLayer renamed = rest;
  renamed.landmarks[2].id = 10;
  const auto other = std::static_pointer_cast<const LandmarkLayer>(landmarks_type().paste(renamed, 1, cut.bytes));
  EXPECT_TRUE(other->landmarks[2].observations.empty()) << "not of the landmark behind the gap";
}

}  // namespace
}  // namespace rastro
