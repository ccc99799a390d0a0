// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/landmarks/landmark_map_testing.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const Map& road() {
  static const Map map = make_landmark_test_map();
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

void expect_same_keyframe(const Map& a, const Map& b, std::size_t k) {
  EXPECT_EQ(a.keyframes[k].id, b.keyframes[k].id);
  EXPECT_EQ(a.keyframes[k].parent, b.keyframes[k].parent);
  EXPECT_LT((a.keyframes[k].world_from_camera.inverse() * b.keyframes[k].world_from_camera).log().norm(), 1e-14);
  const auto of_a = a.layer<FeatureLayer>(), of_b = b.layer<FeatureLayer>();
  const ImageFeatures &x = *of_a->find(a.keyframes[k].id), &y = *of_b->find(b.keyframes[k].id);
  EXPECT_EQ(x.id, y.id);
  EXPECT_EQ(x.frame, y.frame);
  EXPECT_EQ(x.stamp, y.stamp);
  EXPECT_EQ(x.features.levels, y.features.levels);
  EXPECT_EQ(x.features.descriptors, y.features.descriptors);
  EXPECT_EQ(x.features.keypoints.back().x, y.features.keypoints.back().x);
  EXPECT_EQ(x.right_x, y.right_x);
  EXPECT_EQ(x.depths, y.depths);
}

void expect_same(const Map& a, const Map& b) {
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.cameras[0].kind, b.cameras[0].kind);
  EXPECT_EQ(a.cameras[0].intrinsics.fx, b.cameras[0].intrinsics.fx);
  EXPECT_EQ(a.cameras[0].baseline, b.cameras[0].baseline);
  EXPECT_EQ(scale_of(a).metric, scale_of(b).metric);
  EXPECT_EQ(scale_of(a).relative_sigma, scale_of(b).relative_sigma);
  EXPECT_EQ(scale_of(a).origin, scale_of(b).origin);
  EXPECT_EQ(a.layer<FeatureLayer>()->extraction, b.layer<FeatureLayer>()->extraction);
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (std::size_t k = 0; k < a.keyframes.size(); ++k) expect_same_keyframe(a, b, k);
  const auto &of_a = a.layer<LandmarkLayer>()->landmarks, &of_b = b.layer<LandmarkLayer>()->landmarks;
  ASSERT_EQ(of_a.size(), of_b.size());
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    EXPECT_EQ(of_a[i].id, of_b[i].id);
    EXPECT_EQ(of_a[i].position, of_b[i].position);
    EXPECT_EQ(of_a[i].observations, of_b[i].observations);
    EXPECT_EQ(of_a[i].descriptor, of_b[i].descriptor);
  }
  ASSERT_EQ(a.constraints.size(), b.constraints.size());
  EXPECT_EQ(a.constraints[0].inliers, b.constraints[0].inliers);
  EXPECT_EQ(a.frames.size(), b.frames.size());
}

TEST(LandmarkMapFile, ContainsAllOfAMapAndHasTheSameBytesForTheSameMap) {
  EXPECT_EQ(contradiction_in(road()), "");
  for (const CameraKind sensor : {CameraKind::mono, CameraKind::stereo, CameraKind::depth}) {
    TestRoad kind;
    kind.sensor = sensor;
    const Map map = make_landmark_test_map(kind);
    const fs::path file = scratch_path("road.rastro");
    save_map(map, file);
    const auto loaded = load_map(file);
    expect_same(map, *loaded);
    EXPECT_EQ(saved_bytes(*loaded, "again.rastro"), read_whole_file(file)) << "save, load, save";
    EXPECT_EQ(check_map_file(file).version, 4U);
  }
}

TEST(LandmarkMapFile, RefusesAMapThatContradictsItself) {
  const auto change_landmark = [](Map& map, const std::function<void(Landmark&)>& by) {
    auto layer = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
    by(layer->landmarks[3]);
    map.layers.put<LandmarkLayer>(std::move(layer));
  };
  const std::pair<const char*, std::function<void(Map&)>> damages[] = {
      {"keyframe or feature that is not there",
       [&](Map& map) { change_landmark(map, [](Landmark& each) { each.observations.back().keyframe = 999; }); }},
      {"keyframe or feature that is not there",
       [&](Map& map) { change_landmark(map, [](Landmark& each) { each.observations[0].feature = 1 << 20; }); }},
      {"a ring", [](Map& map) { map.keyframes[0].parent = map.keyframes[3].id; }},
      {"leads to a keyframe", [](Map& map) { map.keyframes[4].parent = 5; }},
      {"a constraint to", [](Map& map) { map.constraints[0].to = 999; }},
      {"a frame relative to", [](Map& map) { map.frames[0].keyframe = 999; }}};
  for (const auto& [what, damage] : damages) {
    Map map = road();
    damage(map);
    EXPECT_THAT(contradiction_in(map), HasSubstr(what));
    const fs::path file = scratch_path("bad.rastro");
    save_map(map, file);
    EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr(what));
  }
}

TEST(LandmarkMapFile, NoMeaningfulByteChangesUndetected) {
  TestRoad small;
  small.keyframes = 8, small.landmarks = 600;
  const Map map = make_landmark_test_map(small);
  const std::string whole = saved_bytes(map, "whole.rastro");
  const fs::path file = scratch_path("flipped.rastro");
  Random random(5);
  int seen = 0;
  for (int i = 0; i < 40; ++i) {
    std::string bytes = whole;
    bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^= static_cast<char>(1 + random.below(255));
    write_whole_file(file, bytes);
    const std::string line = message_of([&] {
      const MapFileReport report = check_map_file(file);
      if (!report.damage.empty()) throw Error(report.damage);
      EXPECT_EQ(saved_bytes(*report.map, "resaved.rastro"), whole);
    });
    seen += line != "no error" ? 1 : 0;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
  EXPECT_GT(seen, 10);
}

TEST(RecoverLandmarkMap, RecoversAllOfAValidFileAndTheRestOfADamagedOne) {
  const fs::path file = scratch_path("road.rastro");
  save_map(road(), file);
  const std::string whole = read_whole_file(file);
  const RecoveredMap all = recover_map(file);
  EXPECT_TRUE(all.finished);
  EXPECT_THAT(all.lost, testing::IsEmpty());
  EXPECT_EQ(saved_bytes(*all.map, "all.rastro"), whole);
  std::string holed = whole;
  holed.replace(0, 4096, 4096, 'x');
  holed.replace(20 * 4096, 2 * 4096, 2 * 4096, 'y');
  holed.resize(whole.size() * 9 / 10 / 4096 * 4096);
  write_whole_file(file, holed);
  const RecoveredMap rest = recover_map(file);
  EXPECT_THAT(rest.lost, testing::Contains(HasSubstr("landmarks"))) << "they come last";
  EXPECT_GT(rest.map->keyframes.size(), 5U);
  EXPECT_EQ(contradiction_in(*rest.map), "");
  const fs::path saved = scratch_path("saved.rastro");
  save_map(*rest.map, saved);
  EXPECT_EQ(load_map(saved)->layer<LandmarkLayer>()->landmarks.size(),
            rest.map->layer<LandmarkLayer>()->landmarks.size());
}

/// The map at an earlier time, with fewer keyframes.
Map younger(std::size_t keyframes) {
  Map map = road();
  map.keyframes.resize(keyframes);
  map.constraints.clear();
  std::erase_if(map.frames, [&](const MapFrame& frame) { return !map.index_of(frame.keyframe); });
  auto features = std::make_shared<FeatureLayer>(*map.layer<FeatureLayer>());
  std::erase_if(features->of, [&](const auto& each) { return !map.index_of(each.first); });
  auto layer = std::make_shared<LandmarkLayer>(*map.layer<LandmarkLayer>());
  for (Landmark& landmark : layer->landmarks) {
    std::erase_if(landmark.observations, [&](const auto& each) { return !map.index_of(each.keyframe); });
    landmark.position *= 1.01;
  }
  std::erase_if(layer->landmarks, [](const Landmark& landmark) { return landmark.observations.empty(); });
  map.layers.put<FeatureLayer>(std::move(features));
  map.layers.put<LandmarkLayer>(std::move(layer));
  return map;
}

TEST(GrowingMapFile, OfLandmarksIsReadableWhereItStopped) {
  const fs::path file = scratch_path("stopped.rastro");
  for (const bool shrinks : {false, true}) {
    const Map last = shrinks ? younger(4) : road();
    {
      GrowingMapFile growing(file);
      EXPECT_TRUE(growing.wants_map());
      growing.keep(std::make_shared<Map>(shrinks ? road() : younger(7)));
      while (!fs::exists(file.string() + "-wal")) std::this_thread::yield();
      growing.keep(std::make_shared<Map>(last));
      EXPECT_FALSE(growing.wants_map());
    }
    const MapFileReport report = check_map_file(file);
    EXPECT_EQ(report.damage, "");
    EXPECT_FALSE(report.finished);
    ASSERT_TRUE(report.map);
    EXPECT_EQ(saved_bytes(*report.map, "kept.rastro"), saved_bytes(last, "last.rastro"));
  }
}

TEST(GrowingMapFile, OfLandmarksEndsAsTheFileOfTheMap) {
  const fs::path file = scratch_path("grown.rastro");
  GrowingMapFile growing(file);
  growing.keep(std::make_shared<Map>(younger(7)));
  growing.keep(std::make_shared<Map>(younger(9)));
  growing.finish(road());
  EXPECT_EQ(read_whole_file(file), saved_bytes(road(), "plain.rastro"));
  EXPECT_FALSE(fs::exists(file.string() + "-wal"));
  GrowingMapFile nowhere(scratch_path("no_folder") / "map.rastro");
  EXPECT_THAT(message_of([&] { nowhere.finish(road()); }), HasSubstr("no_folder"));
}

/// Without it, the map lacks what was written last.
TEST(MapFile, ALogThatAKilledRunLeftIsAPartOfTheMap) {
  const fs::path file = scratch_path("logged.rastro"), copy = scratch_path("logged_copy.rastro");
  for (const char* beside : {"logged_copy.rastro-wal", "logged_copy.rastro-shm"}) scratch_path(beside);
  GrowingMapFile growing(file);
  growing.keep(std::make_shared<Map>(younger(7)));
  std::string log;
  while (log.empty()) {
    std::this_thread::yield();
    if (fs::exists(file.string() + "-wal")) log = read_whole_file(file.string() + "-wal");
  }
  write_whole_file(copy, read_whole_file(file));
  write_whole_file(copy.string() + "-wal", log);
  EXPECT_EQ(check_map_file(copy).log_bytes, log.size());
  growing.finish(road());
  EXPECT_EQ(check_map_file(file).log_bytes, 0U);
}

/// What a program killed now would leave: the bytes of the map in the file, empty if there is none yet.
std::string bytes_if_killed_now(const fs::path& file) {
  const fs::path copy = scratch_path("killed.rastro");
  for (const char* beside : {"killed.rastro-wal", "killed.rastro-shm"}) scratch_path(beside);
  try {
    write_whole_file(copy, read_whole_file(file));
    write_whole_file(copy.string() + "-wal", read_whole_file(file.string() + "-wal"));
    return saved_bytes(*load_map(copy), "of_killed.rastro");
  } catch (const Error&) {
    return {};
  }
}

TEST(GrowingMapFile, KilledAtAnyMomentItContainsAnEarlierMap) {
  using Clock = std::chrono::steady_clock;
  const fs::path file = scratch_path("alive.rastro");
  const std::string first = saved_bytes(younger(4), "first.rastro"), second = saved_bytes(road(), "second.rastro");
  GrowingMapFile growing(file);
  growing.keep(std::make_shared<Map>(younger(4)));
  std::string found;
  const auto until = Clock::now() + std::chrono::seconds(20);
  while (found.empty() && Clock::now() < until) found = bytes_if_killed_now(file);
  EXPECT_TRUE(found == first);
  growing.keep(std::make_shared<Map>(road()));
  while (found == first && Clock::now() < until) {
    found = bytes_if_killed_now(file);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(found == second) << "nothing between the first and the second";
}

}  // namespace
}  // namespace rastro
