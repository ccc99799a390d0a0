// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "rastro/map/images/pack_images.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/map/signatures/signature_layer.h"
#include "rastro/map/words/word_layer.h"

namespace rastro {

namespace all_layers {

/// A keyframe of another robot and camera, with a frame and a constraint.
inline void add_other_robot(Map& map) {
  map.sessions.push_back({3, 1, "a recording", 5, 6, {true, 0.01, "a known length"}});
  map.cameras.push_back({CameraKind::depth, TestRoad::camera(), 0.0, {0.003, 0.004}, SE3(SO3(), {0.1, 0.2, 0.3})});
  Keyframe other = map.keyframes.back();
  other.id = keyframe_id({3, 1, 40}), other.parent = map.keyframes[2].id, other.camera = 1, other.weight = 2.5;
  map.keyframes.push_back(other);
  map.frames.push_back({other.stamp + 1, other.id, SE3(SO3::exp({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0})});
  Constraint inter_robot;
  inter_robot.from = map.keyframes[1].id, inter_robot.to = other.id, inter_robot.kind = ConstraintKind::inter_robot;
  inter_robot.from_from_to = Sim3(1.5, SO3::exp({0.3, 0.0, -0.1}), {4.0, 5.0, 6.0});
  inter_robot.weight = 0.25;
  map.constraints.push_back(inter_robot);
}

inline std::shared_ptr<const KeyframeScans> some_scans(std::size_t count, Random& random) {
  auto scans = std::make_shared<KeyframeScans>(count);
  for (KeyframeScan& scan : *scans) {
    scan.sensor = {0.1, random.uniform(-0.2, 0.2)};
    for (int i = 0; i < 40; ++i) {
      const double x = random.uniform(1.0, 4.0), y = random.uniform(-3.0, 3.0);
      scan.points.emplace_back(x, y);
    }
  }
  return scans;
}

inline std::shared_ptr<const SemiDenseDepth> some_depth(std::uint8_t intensity) {
  auto depth = std::make_shared<SemiDenseDepth>();
  for (std::uint16_t i = 0; i < 20; ++i)
    depth->pixels.push_back(
        {static_cast<std::uint16_t>(30 * i), i, 0.5F + 0.01F * static_cast<float>(i), 1e-4F, intensity});
  return depth;
}

inline std::shared_ptr<const BagOfWords> some_words(std::uint32_t first) {
  auto bag = std::make_shared<BagOfWords>();
  bag->words = {{first, 0.25F}, {1000U, 0.75F}};
  bag->nodes = {7U, 3U, 7U};
  return bag;
}

inline Signature some_signature(KeyframeId id) {
  auto image = std::make_shared<ImageFeatures>();
  image->id = id;
  image->features.keypoints.resize(3);
  image->features.descriptors.resize(3);
  image->depths = {1.0F, 0.0F, 2.5F};
  return {std::move(image), {5, -1}};
}

}  // namespace all_layers

/// A small map with every layer, each for some of its keyframes; ids have gaps and belong to two robots. The images are
/// arbitrary bytes that are never unpacked.
inline Map make_map_of_all_layers() {
  TestRoad road;
  road.sensor = CameraKind::stereo, road.keyframes = 8, road.landmarks = 400;
  Map map = make_landmark_test_map(road);
  map.revision = 17;
  all_layers::add_other_robot(map);
  auto images = std::make_shared<ImageLayer>();
  auto image_store = std::make_shared<MemoryImages>();
  auto signatures = std::make_shared<SignatureLayer>();
  auto signature_store = std::make_shared<MemorySignatures>();
  auto scans = std::make_shared<ScanLayer>();
  auto semi_dense = std::make_shared<SemiDenseLayer>();
  auto words = std::make_shared<WordLayer>();
  scans->cell_m = 0.1, scans->model.occupied_probability = 0.8;
  words->vocabulary = "0123456789abcdef";
  Random random(29);
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const KeyframeId id = map.keyframes[k].id;
    const auto byte = static_cast<std::uint8_t>(k + 1);
    if (k % 2 == 0) images->keyframes.push_back(id);
    if (k % 2 == 0) image_store->add(id, {std::vector<std::uint8_t>(6000 + k, byte), {byte, 9}});
    if (k != 5) signatures->keyframes.push_back(id);
    if (k != 5) signature_store->add(id, all_layers::some_signature(id));
    if (k % 3 != 1) scans->of[id] = all_layers::some_scans(1 + k % 2, random);
    if (k % 3 != 2) semi_dense->of[id] = all_layers::some_depth(byte);
    if (k != 4) words->of[id] = all_layers::some_words(byte);
  }
  images->store = image_store;
  signatures->store = signature_store;
  map.layers.put<ImageLayer>(std::move(images));
  map.layers.put<SignatureLayer>(std::move(signatures));
  map.layers.put<ScanLayer>(std::move(scans));
  map.layers.put<SemiDenseLayer>(std::move(semi_dense));
  map.layers.put<WordLayer>(std::move(words));
  return map;
}

}  // namespace rastro
