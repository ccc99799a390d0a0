// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/all_layers_testing.h"
#include "rastro/map/file/map_file.h"

namespace rastro {
namespace {

const char* const every_layer[] = {"features", "images", "landmarks", "scans", "semi_dense", "signatures", "words"};

/// Made once: the tests only read it.
const Map& all() {
  static const Map map = make_map_of_all_layers();
  return map;
}

std::string saved_bytes(const Map& map, const std::string& name) {
  const std::filesystem::path file = scratch_path(name);
  save_map(map, file);
  return read_whole_file(file);
}

/// The map read from a file; saving it again must give the same bytes.
std::shared_ptr<const Map> read_again(const Map& map) {
  EXPECT_EQ(contradiction_in(map), "");
  const std::filesystem::path file = scratch_path("once.rastro");
  save_map(map, file);
  EXPECT_EQ(check_map_file(file).damage, "");
  const auto loaded = load_map(file);
  EXPECT_TRUE(saved_bytes(*loaded, "twice.rastro") == read_whole_file(file));
  return loaded;
}

TEST(Layers, AreKnownByTheirNames) {
  for (const char* name : every_layer) {
    const LayerType* type = layer_type(name);
    ASSERT_TRUE(type) << name;
    EXPECT_EQ(type->name(), name);
    const auto layer = all().layers.find(name);
    ASSERT_TRUE(layer) << name;
    EXPECT_FALSE(type->describe(all(), *layer).text.empty());
    EXPECT_FALSE(type->describe(all(), *layer).numbers.empty());
  }
  EXPECT_FALSE(layer_type("made_up"));
}

TEST(Layers, EachAloneIsReadAndWrittenAgainTheSame) {
  for (const char* name : every_layer) {
    SCOPED_TRACE(name);
    Map map = all();
    map.layers = {};
    map.layers.put(name, all().layers.find(name));
    const auto loaded = read_again(map);
    EXPECT_EQ(loaded->layers.all().size(), 1U);
    ASSERT_TRUE(loaded->layers.find(name));
    const LayerType& type = *layer_type(name);
    EXPECT_EQ(type.header(*loaded->layers.find(name)), type.header(*all().layers.find(name)));
    EXPECT_EQ(type.rows(*loaded->layers.find(name)), type.rows(*all().layers.find(name)));
  }
}

TEST(Layers, AllTogetherKeepTheirContent) {
  const auto loaded = read_again(all());
  EXPECT_EQ(loaded->revision, 17);
  EXPECT_EQ(loaded->layers.all().size(), std::size(every_layer));
  const auto scans = loaded->layer<ScanLayer>();
  EXPECT_EQ(scans->cell_m, 0.1);
  EXPECT_EQ(scans->model.occupied_probability, 0.8);
  EXPECT_EQ(loaded->layer<WordLayer>()->vocabulary, "0123456789abcdef");
  for (const Keyframe& keyframe : all().keyframes) {
    const auto *before = all().layer<ScanLayer>()->find(keyframe.id), *now = scans->find(keyframe.id);
    ASSERT_EQ(now != nullptr, before != nullptr);
    for (std::size_t i = 0; before && i < before->size(); ++i) {
      EXPECT_EQ(now->at(i).sensor, before->at(i).sensor);
      EXPECT_EQ(now->at(i).points, before->at(i).points);
    }
    const auto *bag = all().layer<WordLayer>()->find(keyframe.id),
               *words = loaded->layer<WordLayer>()->find(keyframe.id);
    ASSERT_EQ(words != nullptr, bag != nullptr);
    if (!bag) continue;
    EXPECT_EQ(words->words, bag->words);
    EXPECT_EQ(words->nodes, bag->nodes);
  }
  for (const auto& [id, depth] : all().layer<SemiDenseLayer>()->of) {
    const SemiDenseDepth* now = loaded->layer<SemiDenseLayer>()->find(id);
    ASSERT_TRUE(now);
    ASSERT_EQ(now->pixels.size(), depth->pixels.size());
    EXPECT_EQ(now->pixels[7].x, depth->pixels[7].x);
    EXPECT_EQ(now->pixels[7].inverse_depth, depth->pixels[7].inverse_depth);
    EXPECT_EQ(now->pixels[7].variance, depth->pixels[7].variance);
    EXPECT_EQ(now->pixels[7].intensity, depth->pixels[7].intensity);
  }
  for (const KeyframeId id : all().layer<ImageLayer>()->keyframes)
    EXPECT_EQ(images_of(*loaded)->read(id), images_of(all())->read(id));
}

TEST(Layers, ACameraOfTheRationalModelIsKeptWithItsEightCoefficients) {
  Map map = all();
  map.cameras[1].intrinsics.distortion = Distortion::rational;
  map.cameras[1].intrinsics.coefficients = {0.5, -0.3, 0.0004, -0.0003, 0.3, 0.6, 0.1, 0.3};
  const auto loaded = read_again(map);
  ASSERT_EQ(loaded->cameras.size(), 2U);
  EXPECT_EQ(loaded->cameras[0].intrinsics.distortion, all().cameras[0].intrinsics.distortion);
  EXPECT_EQ(loaded->cameras[1].intrinsics.distortion, Distortion::rational);
  EXPECT_EQ(loaded->cameras[1].intrinsics.coefficients, map.cameras[1].intrinsics.coefficients);
}

TEST(Layers, TheGraphOfSeveralRobotsAndCamerasIsKeptToo) {
  const auto loaded = read_again(all());
  ASSERT_EQ(loaded->cameras.size(), 2U);
  EXPECT_EQ(loaded->cameras[1].depth_noise, all().cameras[1].depth_noise);
  EXPECT_EQ(loaded->cameras[1].body_from_camera.translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  ASSERT_EQ(loaded->sessions.size(), 2U);
  EXPECT_EQ(loaded->sessions[1].robot, 3);
  EXPECT_EQ(loaded->sessions[1].recording, "a recording");
  const Keyframe* other = loaded->find(keyframe_id({3, 1, 40}));
  ASSERT_TRUE(other);
  EXPECT_EQ(other->camera, 1);
  EXPECT_EQ(other->weight, 2.5);
  EXPECT_EQ(other->parent, all().keyframes[2].id);
  const Constraint& constraint = loaded->constraints.back();
  EXPECT_EQ(constraint.kind, ConstraintKind::inter_robot);
  EXPECT_EQ(constraint.from_from_to.scale(), 1.5);
  EXPECT_EQ(constraint.weight, 0.25);
}

TEST(Layers, LandmarksOfAFilterKeepTheirEstimates) {
  Map map = all();
  map.layers = {};
  auto layer = std::make_shared<LandmarkLayer>();
  for (int i = 0; i < 5; ++i) {
    Landmark& landmark = layer->landmarks.emplace_back();
    landmark.id = 3 * i;
    landmark.position = {1.0 * i, 2.0, 3.0};
    LandmarkEstimate& estimate = layer->estimates.emplace_back();
    estimate.sensor_id = i == 2 ? -1 : 100 - i;
    estimate.observations = 10 + i;
    estimate.covariance << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0 + i;
  }
  map.layers.put<LandmarkLayer>(layer);
  const auto now = read_again(map)->layer<LandmarkLayer>();
  ASSERT_EQ(now->estimates.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(now->landmarks[i].id, layer->landmarks[i].id);
    EXPECT_EQ(now->landmarks[i].position, layer->landmarks[i].position);
    EXPECT_EQ(now->estimates[i].sensor_id, layer->estimates[i].sensor_id);
    EXPECT_EQ(now->estimates[i].observations, layer->estimates[i].observations);
    EXPECT_EQ(now->estimates[i].covariance, layer->estimates[i].covariance);
  }
  EXPECT_EQ(now->find(6), &now->landmarks[2]);
  EXPECT_FALSE(now->find(7));
}

TEST(Layers, AnUnknownOneIsKeptUnchanged) {
  Map map = all();
  auto unknown = std::make_shared<UnknownLayer>();
  unknown->header = std::string("of\0another", 10);
  unknown->rows = {{0, "first"}, {5, std::string("\0\xff", 2)}, {keyframe_id({3, 1, 40}), ""}};
  map.layers.put("made_up", unknown);
  const auto loaded = read_again(map);
  const auto now = std::dynamic_pointer_cast<const UnknownLayer>(loaded->layers.find("made_up"));
  ASSERT_TRUE(now);
  EXPECT_EQ(now->header, unknown->header);
  EXPECT_EQ(now->rows, unknown->rows);
  EXPECT_EQ(loaded->layers.all().size(), std::size(every_layer) + 1);
}

TEST(Layers, BytesThatEndTooEarlyOrTooLateAreErrors) {
  const std::string where = "a row";
  for (const char* name : every_layer) {
    SCOPED_TRACE(name);
    const LayerType& type = *layer_type(name);
    const Layer& layer = *all().layers.find(name);
    const std::string header = type.header(layer);
    for (std::size_t size = 0; size < header.size(); ++size)
      EXPECT_THROW(type.make(header.substr(0, size), where), Error) << size;
    if (!header.empty()) {
      EXPECT_THROW(type.make(header + '\0', where), Error);
    }
    const std::int64_t id = type.rows(layer).front();
    const std::string body = type.row(layer, id);
    const auto read = [&](const std::string& bytes) { type.read(*type.make(header, where), id, bytes, where); };
    EXPECT_NO_THROW(read(body));
    EXPECT_THROW(read(body + '\0'), Error);
    // No bytes at all: images are in an attached file.
    for (std::size_t size = 1; size < body.size(); ++size) EXPECT_THROW(read(body.substr(0, size)), Error) << size;
  }
}

TEST(Layers, ARepairedOneFitsAMapThatLostKeyframes) {
  Map map = all();
  std::erase_if(map.keyframes, [](const Keyframe& keyframe) { return keyframe.frame == 30; });  // has all layers
  ASSERT_LT(map.keyframes.size(), all().keyframes.size());
  const LayerSet::Layers layers = map.layers.all();
  for (const auto& [name, layer] : layers) {
    SCOPED_TRACE(name);
    const LayerType& type = *layer_type(name);
    EXPECT_NE(type.contradiction(map, *layer), "");
    const auto repaired = type.repaired(map, layer);
    EXPECT_EQ(type.contradiction(map, *repaired), "");
    EXPECT_FALSE(type.rows(*repaired).empty());
  }
}

TEST(Layers, PointsAreThoseOfAllLayersWithSurfaces) {
  std::size_t expected = all().layer<LandmarkLayer>()->landmarks.size();
  for (const auto& [id, scans] : all().layer<ScanLayer>()->of)
    for (const KeyframeScan& scan : *scans) expected += scan.points.size();
  for (const auto& [id, depth] : all().layer<SemiDenseLayer>()->of) expected += depth->pixels.size();
  EXPECT_EQ(layer_points(all(), -1).points.size(), expected);
  EXPECT_EQ(layer_points(all(), 0).points.size(), expected);
  EXPECT_TRUE(layer_points(all(), 1).points.empty());
  std::size_t left_out = 0;
  for (const auto& [id, depth] : all().layer<SemiDenseLayer>()->of) left_out += depth->pixels.size() - 1;
  EXPECT_GT(left_out, 0U);
  EXPECT_EQ(layer_points(all(), 0, 1).points.size(), expected - left_out) << "the first pixel of each keyframe";
}

}  // namespace
}  // namespace rastro
