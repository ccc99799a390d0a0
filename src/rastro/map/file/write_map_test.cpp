// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/write_map.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/graph_rows.h"

namespace rastro {
namespace {

/// Keyframes with these ids and weights.
Map map_of(const std::vector<std::pair<KeyframeId, double>>& keyframes) {
  Map map;
  map.method = "orb";
  for (const auto& [id, weight] : keyframes) {
    Keyframe keyframe;
    keyframe.id = id;
    keyframe.weight = weight;
    map.keyframes.push_back(keyframe);
  }
  return map;
}

std::vector<std::pair<std::int64_t, std::string>> keyframe_rows(const Database& database) {
  std::vector<std::pair<std::int64_t, std::string>> rows;
  RowReader reader(database, "keyframes");
  while (reader.next()) rows.emplace_back(reader.id(), reader.body());
  return rows;
}

/// Whatever came, went or changed, the table is that of the map alone.
TEST(WriteChanges, GivesTheTableOfTheMap) {
  Database changed = Database::create(scratch_path("changed.rastro"));
  WrittenMap written;
  for (const Map& map : {map_of({{1, 1.0}, {2, 1.0}, {5, 1.0}, {9, 1.0}}),
                         map_of({{0, 1.0}, {2, 1.0}, {3, 1.0}, {5, 7.0}, {9, 1.0}, {10, 1.0}}), map_of({}),
                         map_of({{4, 1.0}, {5, 7.0}}), map_of({{4, 1.0}, {5, 7.0}}), map_of({{5, 2.0}})}) {
    write_changes(map, map.sessions, LayersWritten::all, written, changed);
    Database fresh = Database::create(scratch_path("fresh.rastro"));
    WrittenMap alone;
    write_changes(map, map.sessions, LayersWritten::all, alone, fresh);
    EXPECT_EQ(keyframe_rows(changed), keyframe_rows(fresh));
    EXPECT_EQ(keyframe_rows(changed).size(), map.keyframes.size());
    ASSERT_EQ(written.tables["keyframes"].size(), map.keyframes.size());
    for (std::size_t k = 0; k < map.keyframes.size(); ++k)
      EXPECT_EQ(written.tables["keyframes"][k].hash, alone.tables["keyframes"][k].hash);
  }
}

/// So are the tables whose rows are only counted, in 8 bytes of memory a frame.
TEST(WriteChanges, GivesTheFramesOfTheMap) {
  Database changed = Database::create(scratch_path("changed.rastro"));
  WrittenMap written;
  for (const std::vector<TimeNs>& stamps : std::vector<std::vector<TimeNs>>{
           {1, 2, 3}, {1, 2, 3, 4, 5}, {1, 7, 3, 4, 5}, {2}, {}, {2, 3}, {2, 3}, {9, 3, 4}}) {
    Map map = map_of({{0, 1.0}});
    for (const TimeNs stamp : stamps) map.frames.push_back({stamp, 0, SE3()});
    write_changes(map, map.sessions, LayersWritten::all, written, changed);
    std::vector<TimeNs> in_file;
    RowReader reader(changed, "frames");
    while (reader.next()) {
      EXPECT_EQ(reader.id(), static_cast<std::int64_t>(in_file.size()));
      in_file.push_back(read_frame(std::string(reader.body()), "frames").stamp);
    }
    EXPECT_EQ(in_file, stamps);
    EXPECT_EQ(written.numbered["frames"].size(), stamps.size());
    EXPECT_FALSE(written.tables.contains("frames"));
  }
}

/// Nothing is written twice.
TEST(WriteChanges, LeavesFramesThatAreTheSameAlone) {
  Database database = Database::create(scratch_path("same.rastro"));
  WrittenMap written;
  Map map = map_of({{0, 1.0}});
  for (const TimeNs stamp : {1, 2, 3}) map.frames.push_back({stamp, 0, SE3()});
  write_changes(map, map.sessions, LayersWritten::all, written, database);
  database.remove("frames", 0);
  database.remove("frames", 1);
  map.frames[1].stamp = 5;
  write_changes(map, map.sessions, LayersWritten::all, written, database);
  EXPECT_FALSE(row_of(database, "frames", 0)) << "it has not changed";
  EXPECT_TRUE(row_of(database, "frames", 1));
}

}  // namespace
}  // namespace rastro
