// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <chrono>
#include <functional>
#include <thread>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/images/room_map_testing.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Made once: most tests only read it.
const Map& room() {
  static const Map map = make_test_map();
  return map;
}

std::string saved_bytes(const Map& map, const std::string& name) {
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

void expect_same_features(const ImageFeatures& a, const ImageFeatures& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.depths, b.depths);
  EXPECT_EQ(a.features.descriptors, b.features.descriptors);
  EXPECT_EQ(a.features.levels, b.features.levels);
}

void expect_same(const Map& a, const Map& b) {
  EXPECT_EQ(a.method, b.method);
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  EXPECT_EQ(a.cameras[0].kind, b.cameras[0].kind);
  EXPECT_EQ(a.cameras[0].depth_noise, b.cameras[0].depth_noise);
  EXPECT_EQ(a.cameras[0].intrinsics.fx, b.cameras[0].intrinsics.fx);
  EXPECT_EQ(a.cameras[0].intrinsics.width, b.cameras[0].intrinsics.width);
  EXPECT_EQ(scale_of(a).metric, scale_of(b).metric);
  EXPECT_EQ(scale_of(a).origin, scale_of(b).origin);
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (std::size_t i = 0; i < a.keyframes.size(); ++i) {
    const Keyframe &x = a.keyframes[i], &y = b.keyframes[i];
    EXPECT_EQ(x.id, y.id);
    EXPECT_EQ(x.frame, y.frame);
    EXPECT_EQ(x.stamp, y.stamp);
    EXPECT_EQ(x.submap, y.submap);
    EXPECT_EQ(x.parent, y.parent);
    EXPECT_LT((x.world_from_camera.inverse() * y.world_from_camera).log().norm(), 1e-14);
    expect_same_features(*a.layer<FeatureLayer>()->find(x.id), *b.layer<FeatureLayer>()->find(y.id));
    EXPECT_EQ(images_of(a)->read(x.id), images_of(b)->read(y.id));
  }
  ASSERT_EQ(a.constraints.size(), b.constraints.size());
  for (std::size_t i = 0; i < a.constraints.size(); ++i) {
    EXPECT_EQ(a.constraints[i].kind, b.constraints[i].kind);
    EXPECT_EQ(a.constraints[i].to, b.constraints[i].to);
    EXPECT_EQ(a.constraints[i].information, b.constraints[i].information);
  }
  EXPECT_EQ(a.frames.size(), b.frames.size());
}

TEST(MapFile, ContainsAllOfAMapAndHasTheSameBytesForTheSameMap) {
  const std::string bytes = saved_bytes(room(), "first.rastro");
  EXPECT_EQ(bytes, saved_bytes(room(), "second.rastro"));
  const fs::path file = scratch_path("room.rastro");
  save_map(room(), file);
  const auto loaded = load_map(file);
  expect_same(room(), *loaded);
  EXPECT_EQ(saved_bytes(*loaded, "again.rastro"), bytes) << "save, load, save";
  const MapFileReport report = check_map_file(file);
  EXPECT_EQ(report.damage, "");
  EXPECT_EQ(report.version, 4U);
  EXPECT_EQ(report.bytes, bytes.size());
  EXPECT_TRUE(report.finished);
  EXPECT_FALSE(fs::exists(file.string() + "-wal"));
  EXPECT_FALSE(fs::exists(file.string() + ".new"));
}

TEST(MapFile, PosesOfAnyRotationKeepTheirBytes) {
  Map map = room();
  Random random(7);
  map.frames.clear();
  for (int i = 0; i < 3000; ++i) {
    Vector6d tangent;
    for (double& value : tangent) value = random.uniform(-2.0, 2.0);
    map.frames.push_back({i, i % 6, SE3::exp(tangent)});
  }
  const fs::path file = scratch_path("turned.rastro");
  save_map(map, file);
  EXPECT_EQ(saved_bytes(*load_map(file), "turned_again.rastro"), read_whole_file(file));
}

TEST(MapFile, AnEmptyMapAndFloatDescriptorsAreMapsToo) {
  const fs::path file = scratch_path("empty.rastro");
  save_map(Map(), file);
  EXPECT_TRUE(load_map(file)->cameras.empty());
  Map map;
  map.cameras = room().cameras;
  save_map(map, file);
  EXPECT_TRUE(load_map(file)->keyframes.empty());
  auto image = std::make_shared<ImageFeatures>();
  image->features.keypoints.resize(2);
  image->features.length = 3;
  image->features.floats = {1, 2, 3, 4, 5, 6};
  image->depths = {1.0F, 0.0F};
  auto features = std::make_shared<FeatureLayer>();
  features->of[0] = image;
  map.layers.put<FeatureLayer>(std::move(features));
  map.keyframes.resize(1);
  save_map(map, file);
  EXPECT_EQ(load_map(file)->layer<FeatureLayer>()->find(0)->features.floats, image->features.floats);
}

TEST(MapFile, AnInvalidFileIsRefusedInOneLine) {
  const fs::path file = scratch_path("bad.rastro");
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("no such file"));
  write_whole_file(file, "a text");
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("not a map of rastro"));
  EXPECT_THAT(message_of([&] { check_map_file(file); }), HasSubstr("not a map of rastro"));
  EXPECT_FALSE(is_map_file(file));
  save_map(room(), file);
  EXPECT_TRUE(is_map_file(file));
  const std::string whole = read_whole_file(file);
  write_whole_file(file, whole.substr(0, whole.size() / 2));
  EXPECT_THAT(message_of([&] { load_map(file); }), testing::AllOf(HasSubstr("cut off"), HasSubstr("recover")));
  write_whole_file(file, whole);
  run_sql(file, "PRAGMA user_version=5");
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("version 5"));
}

TEST(MapFile, EveryModifiedRowIsDamage) {
  const fs::path file = scratch_path("bad.rastro");
  const std::string whole = saved_bytes(room(), "whole.rastro");
  const std::string form = " (id INTEGER PRIMARY KEY, checksum INTEGER NOT NULL, body BLOB NOT NULL)";
  const std::string damages[] = {"DELETE FROM keyframes WHERE id=2",
                                 "UPDATE keyframes SET id=9 WHERE id=3",
                                 "DELETE FROM constraints",
                                 "UPDATE constraints SET body=x'00' WHERE id=1",
                                 "UPDATE cameras SET body=x'00'",
                                 "DELETE FROM sessions",
                                 "UPDATE head SET body='text'",
                                 "UPDATE contents SET checksum=1 WHERE id=0",
                                 "DELETE FROM layers WHERE id=1",
                                 "UPDATE layer_features SET body=x'00' WHERE id=4",
                                 "DELETE FROM layer_images WHERE id=3",
                                 "DROP TABLE frames",
                                 "DROP TABLE layer_images",
                                 "CREATE TABLE more (x)",
                                 "CREATE TABLE more" + form,
                                 "CREATE TABLE layer_more" + form,
                                 "CREATE TABLE layer_Images2" + form,
                                 "CREATE VIEW layer_view AS SELECT * FROM head"};
  for (const std::string& sql : damages) {
    write_whole_file(file, whole);
    run_sql(file, sql);
    EXPECT_THAT(message_of([&] { load_map(file); }), testing::AllOf(HasSubstr("bad.rastro"), HasSubstr("recover")))
        << sql;
    EXPECT_FALSE(check_map_file(file).damage.empty()) << sql;
  }
}

TEST(MapFile, ADamagedImageIsDetectedWhenItIsRead) {
  const fs::path file = scratch_path("image.rastro");
  save_map(room(), file);
  run_sql(file, "UPDATE layer_images SET body=x'00' WHERE id=3");
  const auto map = load_map(file);
  EXPECT_EQ(images_of(*map)->read(2), images_of(room())->read(2));
  EXPECT_THAT(message_of([&] { images_of(*map)->read(3); }), HasSubstr("row 3 of layer_images"));
  EXPECT_THAT(check_map_file(file).damage, HasSubstr("row 3 of layer_images"));
}

TEST(MapFile, NoMeaningfulByteChangesUndetected) {
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
      // An unnoticed change is harmless: space between rows, or counters of SQLite.
      EXPECT_EQ(saved_bytes(*report.map, "resaved.rastro"), whole);
    });
    seen += line != "no error" ? 1 : 0;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
  EXPECT_GT(seen, 10);
}

TEST(RecoverMap, RecoversAllOfAValidFile) {
  const fs::path file = scratch_path("sound.rastro");
  save_map(room(), file);
  const RecoveredMap recovered = recover_map(file);
  EXPECT_TRUE(recovered.finished);
  EXPECT_THAT(recovered.lost, testing::IsEmpty());
  EXPECT_EQ(saved_bytes(*recovered.map, "recovered.rastro"), read_whole_file(file));
}

TEST(RecoverMap, RecoversTheRestOfATruncatedFile) {
  const fs::path file = scratch_path("torn.rastro");
  const std::string whole = saved_bytes(room(), "whole.rastro");
  write_whole_file(file, whole.substr(0, whole.size() * 3 / 4));  // within the images, which come last
  const RecoveredMap half = recover_map(file);
  EXPECT_EQ(half.map->keyframes.size(), 6U);
  EXPECT_EQ(half.map->layer<FeatureLayer>()->of.size(), 6U);
  EXPECT_THAT(half.map->layer<ImageLayer>()->keyframes.size(), testing::AllOf(testing::Ge(2U), testing::Lt(6U)));
  EXPECT_TRUE(half.finished) << "the table of contents is among the first pages";
  EXPECT_THAT(half.lost, testing::ElementsAre(HasSubstr("of 6 images")));
  save_map(*half.map, scratch_path("half.rastro"));
  write_whole_file(file, std::string(10000, 'z'));
  EXPECT_THAT(message_of([&] { recover_map(file); }), HasSubstr("nothing of a map"));
}

/// Offset of the middle of a row with this body, on a page that contains nothing else.
std::size_t middle_of(const std::string& file, const std::string& body) {
  constexpr std::size_t piece = 64;
  for (std::size_t begin = body.size() / 2; begin + piece <= body.size(); begin += piece) {
    const std::size_t at = file.find(body.substr(begin, piece));
    if (at != std::string::npos) return at;
  }
  return std::string::npos;
}

void lose_page(std::string& file, std::size_t at) {
  constexpr std::size_t page = 4096;
  ASSERT_LT(at, file.size());
  file.replace(at / page * page, page, page, 'y');
}

TEST(RecoverMap, LosingAPageOfAnImageAndTheFirstPageCostsThatImageAlone) {
  const fs::path file = scratch_path("holed.rastro");
  std::string holed = saved_bytes(room(), "whole.rastro");
  lose_page(holed, 0);  // SQLite's header and the names of the tables
  const std::vector<std::uint8_t> color = images_of(room())->read(2).color;
  ASSERT_GT(color.size(), 12'288U);
  lose_page(holed, middle_of(holed, {color.begin(), color.end()}));
  write_whole_file(file, holed);
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("try 'rastro recover'"));
  const RecoveredMap rest = recover_map(file);
  EXPECT_EQ(rest.map->keyframes.size(), 6U);
  EXPECT_EQ(rest.map->layer<ImageLayer>()->keyframes, (std::vector<KeyframeId>{0, 1, 3, 4, 5}));
  EXPECT_THAT(rest.lost, testing::ElementsAre("1 of 6 images"));
  EXPECT_EQ(rest.map->frames.size(), room().frames.size());
}

/// The first bytes of a keyframe's row: no other row has them.
std::string begin_of_row(const Keyframe& keyframe) {
  std::string bytes(reinterpret_cast<const char*>(&keyframe.frame), sizeof keyframe.frame);
  bytes.append(reinterpret_cast<const char*>(&keyframe.stamp), sizeof keyframe.stamp);
  return bytes + std::string(2 * sizeof(std::int32_t), '\0');  // camera 0, submap 0
}

TEST(RecoverMap, ALostKeyframeTakesItsLayersConstraintsAndFramesWithIt) {
  const fs::path file = scratch_path("lost.rastro");
  std::string holed = saved_bytes(room(), "whole.rastro");
  const std::size_t at = holed.find(begin_of_row(room().keyframes[2]));
  ASSERT_NE(at, std::string::npos);
  holed[at] ^= 1;
  write_whole_file(file, holed);
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("row 2 of keyframes"));
  const RecoveredMap rest = recover_map(file);
  EXPECT_THAT(rest.lost, testing::ElementsAre("1 of 6 keyframes", "2 constraints of lost keyframes",
                                              "5 frames of lost keyframes"));
  EXPECT_EQ(rest.map->keyframes.size(), 5U);
  EXPECT_FALSE(rest.map->find(2));
  EXPECT_FALSE(rest.map->layer<FeatureLayer>()->find(2));
  EXPECT_EQ(rest.map->layer<ImageLayer>()->keyframes, (std::vector<KeyframeId>{0, 1, 3, 4, 5}));
  EXPECT_EQ(contradiction_in(*rest.map), "");
  const fs::path saved = scratch_path("saved.rastro");
  save_map(*rest.map, saved);
  EXPECT_EQ(check_map_file(saved).damage, "");
}

TEST(RecoverMap, AConstraintThatCannotBeOptimizedIsRefusedAndCostsItself) {
  Map map = room();
  map.constraints[1].information(3, 3) = -1.0;
  const fs::path file = scratch_path("indefinite.rastro");
  save_map(map, file);
  EXPECT_THAT(message_of([&] { load_map(file); }),
              testing::AllOf(HasSubstr("indefinite.rastro"), HasSubstr("not positive definite"), HasSubstr("recover")));
  const RecoveredMap rest = recover_map(file);
  EXPECT_THAT(rest.lost, testing::ElementsAre("1 constraints that cannot be optimized"));
  EXPECT_EQ(rest.map->constraints.size(), room().constraints.size() - 1);
  EXPECT_EQ(rest.map->keyframes.size(), room().keyframes.size());
  const fs::path saved = scratch_path("saved.rastro");
  save_map(*rest.map, saved);
  EXPECT_EQ(check_map_file(saved).damage, "");
}

void add_all_images(const Map& map, MapArchive& archive) {
  for (const Keyframe& keyframe : map.keyframes) archive.add_images(keyframe.id, images_of(map)->read(keyframe.id));
}

/// With its images in the archive.
Map kept_in(const MapArchive& archive, const Map& map) {
  Map result = map;
  auto images = std::make_shared<ImageLayer>(*map.layer<ImageLayer>());
  images->store = archive.images();
  result.layers.put<ImageLayer>(std::move(images));
  return result;
}

TEST(GrowingMapFile, EndsAsTheFileOfTheMap) {
  const fs::path file = scratch_path("grown.rastro");
  GrowingMapFile growing(file);
  add_all_images(room(), growing);
  const Map map = kept_in(growing, room());
  EXPECT_EQ(images_of(map)->read(4), images_of(room())->read(4)) << "before anything need be on the disk";
  growing.keep(std::make_shared<Map>(map));
  growing.finish(map);
  EXPECT_EQ(images_of(map)->read(4), images_of(room())->read(4)) << "from the final file";
  EXPECT_EQ(read_whole_file(file), saved_bytes(room(), "plain.rastro"));
  EXPECT_FALSE(fs::exists(file.string() + "-wal"));
}

TEST(GrowingMapFile, EndsTheSameWithoutAnythingKeptBefore) {
  const fs::path file = scratch_path("at_once.rastro");
  GrowingMapFile growing(file);
  growing.finish(room());
  EXPECT_EQ(read_whole_file(file), saved_bytes(room(), "plain.rastro"));
  EXPECT_EQ(growing.images()->read(4), images_of(room())->read(4));
}

/// What is in the file already is written again where it changed at all.
TEST(GrowingMapFile, AKeyframeThatOnlyTurnedIsWrittenAgain) {
  const fs::path file = scratch_path("turned.rastro");
  Map map = room();
  {
    GrowingMapFile growing(file);
    add_all_images(room(), growing);
    growing.keep(std::make_shared<Map>(kept_in(growing, map)));
    for (int tries = 0; tries < 100 && !growing.wants_map(); ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ASSERT_TRUE(growing.wants_map()) << "the first was not written";
    SE3& pose = map.keyframes[2].world_from_camera;
    pose = SE3(pose.rotation() * SO3::exp({0.0, 0.1, 0.0}), pose.translation());
    ++map.revision;
    growing.keep(std::make_shared<Map>(kept_in(growing, map)));
  }
  const MapFileReport report = check_map_file(file);
  ASSERT_TRUE(report.map);
  expect_same(map, *report.map);
}

TEST(GrowingMapFile, IsReadableWhereItStopped) {
  const fs::path file = scratch_path("stopped.rastro");
  {
    GrowingMapFile growing(file);
    add_all_images(room(), growing);
    growing.keep(std::make_shared<Map>(kept_in(growing, room())));
  }
  const MapFileReport report = check_map_file(file);
  EXPECT_EQ(report.damage, "");
  EXPECT_FALSE(report.finished);
  ASSERT_TRUE(report.map);
  expect_same(room(), *report.map);
  EXPECT_EQ(saved_bytes(*report.map, "kept.rastro"), saved_bytes(room(), "plain.rastro"));
}

TEST(GrowingMapFile, ImagesOfKeyframesThatWereNotKeptAreHarmless) {
  const fs::path file = scratch_path("early.rastro");
  Map map = make_test_map(3);
  {
    GrowingMapFile growing(file);
    add_all_images(room(), growing);
    growing.keep(std::make_shared<Map>(kept_in(growing, map)));
  }
  const MapFileReport report = check_map_file(file);
  EXPECT_EQ(report.damage, "");
  ASSERT_TRUE(report.map);
  EXPECT_EQ(report.map->layer<ImageLayer>()->keyframes, (std::vector<KeyframeId>{0, 1, 2}));
}

TEST(GrowingMapFile, AWrongPathIsReportedByTheNextCall) {
  GrowingMapFile images(scratch_path("no_folder") / "map.rastro");
  EXPECT_THAT(message_of([&] { images.add_images(0, {}); }), HasSubstr("no_folder"));
  GrowingMapFile nowhere(scratch_path("no_folder") / "map.rastro");
  const auto map = std::make_shared<Map>(room());
  std::string said = "no error";
  for (int i = 0; i < 1000 && said == "no error"; ++i) {
    said = message_of([&] { nowhere.keep(map); });
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_THAT(said, HasSubstr("no_folder"));
}

TEST(GrowingMapFile, ImagesAreReadByManyThreads) {
  GrowingMapFile growing(scratch_path("threads.rastro"));
  std::vector<std::thread> readers;
  for (KeyframeId id = 0; id < 6; ++id) {
    growing.add_images(id, images_of(room())->read(id));
    readers.emplace_back([&, id] {
      for (int i = 0; i < 20; ++i) EXPECT_EQ(growing.images()->read(id).bytes(), images_of(room())->read(id).bytes());
    });
  }
  for (std::thread& reader : readers) reader.join();
  EXPECT_THROW(growing.images()->read(99), Error);
}

}  // namespace
}  // namespace rastro
