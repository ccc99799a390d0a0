// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdlib>
#include <fstream>
#include <thread>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/rgbd_map_testing.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Made once: most tests only look.
const RgbdMap& room() {
  static const RgbdMap map = make_test_map();
  return map;
}

std::string saved_bytes(const RgbdMap& map, const std::string& name) {
  const fs::path file = scratch_path(name);
  save_map(map, file);
  return read_whole_file(file);
}

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void run_sql(const fs::path& file, const std::string& sql) {
  sqlite3* connection = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &connection), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(connection, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
  sqlite3_close(connection);
}

void expect_same(const RgbdMap& a, const RgbdMap& b) {
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.camera.fx, b.camera.fx);
  EXPECT_EQ(a.camera.width, b.camera.width);
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (std::size_t i = 0; i < a.keyframes.size(); ++i) {
    EXPECT_EQ(a.keyframes[i]->id, b.keyframes[i]->id);
    EXPECT_EQ(a.keyframes[i]->stamp, b.keyframes[i]->stamp);
    EXPECT_EQ(a.keyframes[i]->depths, b.keyframes[i]->depths);
    EXPECT_EQ(a.keyframes[i]->features.bits, b.keyframes[i]->features.bits);
    EXPECT_EQ(a.poses[i].submap, b.poses[i].submap);
    EXPECT_LT((a.poses[i].world_from_camera.inverse() * b.poses[i].world_from_camera).log().norm(), 1e-14);
    EXPECT_EQ(a.pictures->pictures(a.keyframes[i]->id), b.pictures->pictures(b.keyframes[i]->id));
  }
  ASSERT_EQ(a.edges.size(), b.edges.size());
  for (std::size_t i = 0; i < a.edges.size(); ++i) {
    EXPECT_EQ(a.edges[i].kind, b.edges[i].kind);
    EXPECT_EQ(a.edges[i].to, b.edges[i].to);
    EXPECT_EQ(a.edges[i].information, b.edges[i].information);
  }
  EXPECT_EQ(a.trajectory.size(), b.trajectory.size());
}

TEST(MapFile, HoldsAllOfAMapAndTheSameBytesForTheSameMap) {
  const std::string bytes = saved_bytes(room(), "first.rastro");
  EXPECT_EQ(bytes, saved_bytes(room(), "second.rastro"));
  const fs::path file = scratch_path("room.rastro");
  save_map(room(), file);
  const auto loaded = load_map(file);
  expect_same(room(), *loaded);
  EXPECT_EQ(saved_bytes(*loaded, "again.rastro"), bytes) << "save, load, save";
  EXPECT_FALSE(fs::exists(file.string() + "-wal"));
  EXPECT_FALSE(fs::exists(file.string() + ".new"));
}

TEST(MapFile, PosesOfAnyRotationKeepTheirBytes) {
  RgbdMap map = room();
  Random random(7);
  map.trajectory.clear();
  for (int i = 0; i < 3000; ++i) {
    Vector6d tangent;
    for (double& value : tangent) value = random.uniform(-2.0, 2.0);
    map.trajectory.push_back({i, SE3::exp(tangent)});
  }
  const fs::path file = scratch_path("turned.rastro");
  save_map(map, file);
  EXPECT_EQ(saved_bytes(*load_map(file), "turned_again.rastro"), read_whole_file(file));
}

TEST(MapFile, AnEmptyMapAndFloatDescriptorsAreMapsToo) {
  RgbdMap map;
  map.camera = room().camera;
  const fs::path file = scratch_path("empty.rastro");
  save_map(map, file);
  EXPECT_TRUE(load_map(file)->keyframes.empty());
  auto keyframe = std::make_shared<RgbdKeyframe>();
  keyframe->features.keypoints.resize(2);
  keyframe->features.length = 3;
  keyframe->features.floats = {1, 2, 3, 4, 5, 6};
  keyframe->depths = {1.0F, 0.0F};
  map.keyframes = {keyframe};
  map.poses.resize(1);
  const auto pictures = std::make_shared<MemoryPictures>();
  pictures->add(0, {});
  map.pictures = pictures;
  save_map(map, file);
  EXPECT_EQ(load_map(file)->keyframes[0]->features.floats, keyframe->features.floats);
}

TEST(MapFile, SaysWhatIsWrongInOneLine) {
  const fs::path file = scratch_path("bad.rastro");
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("cannot be read"));
  write_whole_file(file, "a text");
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("no map of rastro"));
  EXPECT_FALSE(is_map_file(file));
  save_map(room(), file);
  EXPECT_TRUE(is_map_file(file));
  const std::string whole = read_whole_file(file);
  write_whole_file(file, whole.substr(0, whole.size() / 2));
  EXPECT_THAT(message_of([&] { load_map(file); }), testing::AllOf(HasSubstr("cut off"), HasSubstr("recover")));
  write_whole_file(file, whole);
  run_sql(file, "PRAGMA user_version=3");
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("version 3"));
  for (const char* sql : {"DELETE FROM poses WHERE id=2", "DELETE FROM edges", "UPDATE edges SET body=x'00' WHERE id=1",
                          "UPDATE keyframes SET id=9 WHERE id=3", "CREATE TABLE more (x)", "DROP TABLE way",
                          "UPDATE head SET body='text'", "UPDATE contents SET checksum=1 WHERE id=0"}) {
    write_whole_file(file, whole);
    run_sql(file, sql);
    EXPECT_THAT(message_of([&] { load_map(file); }), testing::AllOf(HasSubstr("bad.rastro"), HasSubstr("recover")))
        << sql;
    EXPECT_FALSE(check_map_file(file).damage.empty()) << sql;
  }
}

TEST(MapFile, NoByteThatMeansSomethingChangesUnseen) {
  const fs::path file = scratch_path("flipped.rastro");
  const std::string whole = saved_bytes(make_test_map(2), "whole.rastro");
  Random random(3);
  int seen = 0;
  for (int i = 0; i < 30; ++i) {
    std::string bytes = whole;
    bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^= static_cast<char>(1 + random.below(255));
    write_whole_file(file, bytes);
    const std::string line = message_of([&] {
      const MapFileReport report = check_map_file(file);
      if (!report.damage.empty()) throw Error(report.damage);
      // What is not seen changes nothing: space between rows, or counters of SQLite.
      EXPECT_EQ(saved_bytes(*report.map, "resaved.rastro"), whole);
    });
    seen += line != "no error" ? 1 : 0;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
  EXPECT_GT(seen, 10);
}

TEST(RecoverMap, SavesAllOfASoundFile) {
  const fs::path file = scratch_path("sound.rastro");
  save_map(room(), file);
  const RecoveredMap recovered = recover_map(file);
  EXPECT_TRUE(recovered.finished);
  EXPECT_THAT(recovered.lost, testing::IsEmpty());
  EXPECT_EQ(saved_bytes(*recovered.map, "recovered.rastro"), read_whole_file(file));
}

TEST(RecoverMap, SavesWhatIsLeftOfACutOrOverwrittenFile) {
  const fs::path file = scratch_path("torn.rastro");
  save_map(room(), file);
  const std::string whole = read_whole_file(file);
  write_whole_file(file, whole.substr(0, whole.size() * 3 / 4));  // within the pictures
  const RecoveredMap half = recover_map(file);
  EXPECT_THAT(half.map->keyframes.size(), testing::AllOf(testing::Ge(2U), testing::Lt(6U)));
  EXPECT_TRUE(half.finished) << "the table of contents is among the first pages";
  EXPECT_THAT(half.lost, testing::Contains(HasSubstr("keyframes")));
  save_map(*half.map, scratch_path("half.rastro"));
  std::string holed = whole;
  holed.replace(0, 4096, 4096, 'x');  // the first page, with SQLite's header and the names of the tables
  holed.replace(40 * 4096, 4096, 4096, 'y');
  write_whole_file(file, holed);
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("try 'rastro recover'"));
  const RecoveredMap rest = recover_map(file);
  EXPECT_EQ(rest.map->keyframes.size(), 5U);
  EXPECT_THAT(rest.lost, testing::Contains(HasSubstr("1 of 6 keyframes")));
  EXPECT_EQ(rest.map->trajectory.size(), room().trajectory.size());
  write_whole_file(file, std::string(10000, 'z'));
  EXPECT_THAT(message_of([&] { recover_map(file); }), HasSubstr("nothing of a map"));
}

void add_all(const RgbdMap& map, MapArchive& archive) {
  archive.begin(map);
  for (const auto& keyframe : map.keyframes) archive.add_keyframe(*keyframe, {}, map.pictures->pictures(keyframe->id));
  for (const PoseEdge& edge : map.edges) archive.add_edge(edge);
  for (const StampedPose& pose : map.trajectory) archive.add_pose(pose);
  archive.set_poses(map.poses);
}

TEST(GrowingMapFile, EndsAsTheFileOfTheMap) {
  const fs::path file = scratch_path("grown.rastro");
  RgbdMap map = room();
  GrowingMapFile growing(file);
  add_all(map, growing);
  map.pictures = growing.pictures();
  EXPECT_EQ(map.pictures->pictures(4), room().pictures->pictures(4)) << "before anything need be on the disk";
  growing.finish(map);
  EXPECT_EQ(map.pictures->pictures(4), room().pictures->pictures(4)) << "from the final file";
  EXPECT_EQ(read_whole_file(file), saved_bytes(room(), "plain.rastro"));
  EXPECT_FALSE(fs::exists(file.string() + "-wal"));
}

TEST(GrowingMapFile, IsReadableWhileItGrowsAndWhereItStopped) {
  const fs::path file = scratch_path("stopped.rastro");
  {
    GrowingMapFile growing(file);
    add_all(room(), growing);
  }
  const MapFileReport report = check_map_file(file);
  EXPECT_EQ(report.damage, "");
  EXPECT_FALSE(report.finished);
  expect_same(room(), *report.map);
}

TEST(GrowingMapFile, AWrongPlaceIsSaidAndPicturesAreReadByManyThreads) {
  GrowingMapFile nowhere(scratch_path("no_folder") / "map.rastro");
  nowhere.begin(room());
  EXPECT_THAT(message_of([&] { nowhere.add_edge(room().edges[0]); }), HasSubstr("no_folder"));
  GrowingMapFile growing(scratch_path("threads.rastro"));
  growing.begin(room());
  std::vector<std::thread> readers;
  for (std::int64_t id = 0; id < 6; ++id) {
    growing.add_keyframe(*room().keyframes[static_cast<std::size_t>(id)], {}, room().pictures->pictures(id));
    readers.emplace_back([&, id] {
      for (int i = 0; i < 20; ++i)
        EXPECT_EQ(growing.pictures()->pictures(id).bytes(), room().pictures->pictures(id).bytes());
    });
  }
  for (std::thread& reader : readers) reader.join();
  EXPECT_THROW(growing.pictures()->pictures(99), Error);
}

}  // namespace
}  // namespace rastro
