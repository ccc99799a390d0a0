// SPDX-License-Identifier: Apache-2.0
// A layer that nothing in src/rastro names is saved, read, described, shown and repaired like its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/base/text_file.h"
#include "rastro/export/ply.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/read_map.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/graph/edit.h"
#include "rastro/map/marks/mark_layer.h"

namespace rastro {
namespace {

/// Three keyframes without a camera, a meter from one to the next, the last in a submap of its own; marks in two.
Map marked_map() {
  Map map;
  map.method = "still";
  map.revision = 1;
  map.sessions.push_back({0, 0, "", 0, 200, {true, 0.0, "as set"}});
  auto marks = std::make_shared<MarkLayer>();
  for (int k = 0; k < 3; ++k) {
    const KeyframeId id = 10 * k;
    map.keyframes.push_back({id, k, 100 * k, 0, SE3(SO3(), {1.0 * k, 0.0, 0.0}), k / 2, k == 1 ? 0 : no_keyframe, 1.0});
    map.frames.push_back({100 * k, id, SE3()});
  }
  marks->of[0] = std::make_shared<Marks>(Marks{{"door", {0.1, 0.0, 2.0}}, {"chair", {1.0 / 3.0, -0.5, 1.0}}});
  marks->of[20] = std::make_shared<Marks>(Marks{{"window", {0.0, -1.0, 3.0}}});
  map.layers.put<MarkLayer>(std::move(marks));
  return map;
}

void expect_marks(const Map& map, KeyframeId id, const Marks& expected) {
  const auto layer = map.layer<MarkLayer>();
  ASSERT_TRUE(layer);
  const Marks* marks = layer->find(id);
  ASSERT_TRUE(marks) << id;
  EXPECT_EQ(*marks, expected) << id;
}

void expect_marks_of(const Map& original, const Map& map) {
  ASSERT_TRUE(map.layer<MarkLayer>());
  EXPECT_EQ(map.layer<MarkLayer>()->of.size(), original.layer<MarkLayer>()->of.size());
  for (const auto& [id, marks] : original.layer<MarkLayer>()->of) expect_marks(map, id, *marks);
}

TEST(LayerExtension, StandsBesideRastrosOwnInTheOrderOfNames) {
  std::vector<std::string> names;
  for (const auto& type : layer_types()) names.push_back(type->name());
  EXPECT_THAT(names, testing::IsSupersetOf({"features", "landmarks", "marks", "scans"}));
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  ASSERT_NE(layer_type("marks"), nullptr);
}

TEST(LayerExtension, IsSavedAndReadAgainWithTheSameBytes) {
  const Map map = marked_map();
  ASSERT_EQ(contradiction_in(map), "");
  const auto file = scratch_path("marked.rastro"), again = scratch_path("marked_again.rastro");
  save_map(map, file);
  const auto loaded = load_map(file);
  expect_marks_of(map, *loaded);
  save_map(*loaded, again);
  EXPECT_TRUE(read_text_file(file.string()) == read_text_file(again.string())) << "not the same bytes";
  EXPECT_EQ(check_map_file(file).damage, "");
}

TEST(LayerExtension, ARunThatWasKilledLeavesIt) {
  const Map map = marked_map();
  const auto file = scratch_path("growing.rastro");
  {
    GrowingMapFile growing(file);
    growing.keep(std::make_shared<Map>(map));
  }
  EXPECT_FALSE(check_map_file(file).finished);
  expect_marks_of(map, *load_map(file));
}

TEST(LayerExtension, IsFoundInADamagedFile) {
  const Map map = marked_map();
  const auto file = scratch_path("damaged.rastro");
  save_map(map, file);
  // The first page, with the names of the tables.
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary) << std::string(4096, 'x');
  EXPECT_THROW(load_map(file), Error);
  const RecoveredMap recovered = recover_map(file);
  EXPECT_THAT(recovered.lost, testing::IsEmpty());
  expect_marks_of(map, *recovered.map);
}

TEST(LayerExtension, IsDescribed) {
  const Map map = marked_map();
  const LayerDescription said = layer_type("marks")->describe(map, *map.layer<MarkLayer>());
  EXPECT_EQ(said.text, "3 marks in 2 keyframes");
  EXPECT_THAT(said.numbers, testing::ElementsAre(testing::Pair("marks", 3.0)));
}

TEST(LayerExtension, IsExportedAsPoints) {
  const Map map = marked_map();
  const PointCloud cloud = parse_cloud_ply(cloud_ply(layer_points(map, -1), "frame"), "marks.ply");
  ASSERT_EQ(cloud.points.size(), 3U);
  EXPECT_EQ(cloud.points[0].position, Eigen::Vector3f(0.1F, 0.0F, 2.0F));
  EXPECT_EQ(cloud.points[2].position, Eigen::Vector3f(2.0F, -1.0F, 3.0F)) << "in the world";
  EXPECT_EQ(layer_points(map, 0).points.size(), 2U);
  EXPECT_EQ(layer_points(map, 1).points.size(), 1U);
}

TEST(LayerExtension, RepairKeepsWhatLeadsToAKeyframe) {
  const Map whole = marked_map();
  Map map = whole;
  map.keyframes.pop_back();
  EXPECT_THAT(contradiction_in(map), testing::HasSubstr("keyframe"));
  repair(map);
  EXPECT_EQ(contradiction_in(map), "");
  EXPECT_EQ(map.layer<MarkLayer>()->of.size(), 1U);
  expect_marks(map, 0, *whole.layer<MarkLayer>()->find(0));
}

TEST(LayerExtension, GoesAndComesBackWithItsKeyframe) {
  const Map whole = marked_map();
  Map map = whole;
  const RemovedKeyframe removed = remove_keyframe(map, 20);
  EXPECT_EQ(map.layer<MarkLayer>()->of.size(), 1U);
  EXPECT_EQ(contradiction_in(map), "");
  restore_keyframe(map, removed);
  EXPECT_EQ(contradiction_in(map), "");
  expect_marks_of(whole, map);
  const Map counted = renumbered(whole);
  EXPECT_EQ(contradiction_in(counted), "");
  expect_marks(counted, 2, *whole.layer<MarkLayer>()->find(20));
}

TEST(LayerExtension, BytesThatAreNoMarksAreRefused) {
  const auto layer = layer_type("marks")->make("", "a test");
  for (const char* body : {"1 2", "1 2 3", "one 2 3 door"})
    EXPECT_THROW(layer_type("marks")->read(*layer, 0, body, "a test"), Error) << body;
}

}  // namespace
}  // namespace rastro
