// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/map/file/growing_map_file.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/file/recover_map.h"
#include "rastro/map/landmark/landmark_checks.h"
#include "rastro/map/landmark/landmark_map_testing.h"
#include "rastro/map/rgbd_map_testing.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const LandmarkMap& road() {
  static const LandmarkMap map = make_landmark_test_map();
  return map;
}

std::string saved_bytes(const LandmarkMap& map, const std::string& name) {
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

void expect_same(const LandmarkMap& a, const LandmarkMap& b) {
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.sensor, b.sensor);
  EXPECT_EQ(a.camera.fx, b.camera.fx);
  EXPECT_EQ(a.baseline, b.baseline);
  EXPECT_EQ(a.scale.metric, b.scale.metric);
  EXPECT_EQ(a.scale.relative_sigma, b.scale.relative_sigma);
  EXPECT_EQ(a.scale.origin, b.scale.origin);
  EXPECT_EQ(a.features, b.features);
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (std::size_t k = 0; k < a.keyframes.size(); ++k) {
    const LandmarkKeyframe &x = *a.keyframes[k], &y = *b.keyframes[k];
    EXPECT_EQ(x.id, y.id);
    EXPECT_EQ(x.frame, y.frame);
    EXPECT_EQ(x.stamp, y.stamp);
    EXPECT_EQ(x.features.levels, y.features.levels);
    EXPECT_EQ(x.features.descriptors, y.features.descriptors);
    EXPECT_EQ(x.features.keypoints.back().x, y.features.keypoints.back().x);
    EXPECT_EQ(x.right_x, y.right_x);
    EXPECT_EQ(x.depths, y.depths);
    EXPECT_EQ(a.poses[k].parent, b.poses[k].parent);
    EXPECT_LT((a.poses[k].world_from_camera.inverse() * b.poses[k].world_from_camera).log().norm(), 1e-14);
  }
  ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
  for (std::size_t i = 0; i < a.landmarks.size(); ++i) {
    EXPECT_EQ(a.landmarks[i].id, b.landmarks[i].id);
    EXPECT_EQ(a.landmarks[i].position, b.landmarks[i].position);
    EXPECT_EQ(a.landmarks[i].observations, b.landmarks[i].observations);
    EXPECT_EQ(a.landmarks[i].descriptor, b.landmarks[i].descriptor);
  }
  ASSERT_EQ(a.ties.size(), b.ties.size());
  EXPECT_EQ(a.ties[0].inliers, b.ties[0].inliers);
  EXPECT_EQ(a.trajectory.size(), b.trajectory.size());
}

TEST(LandmarkMapFile, HoldsAllOfAMapAndTheSameBytesForTheSameMap) {
  EXPECT_EQ(contradiction_in(road()), "");
  for (const LandmarkSensor sensor : {LandmarkSensor::mono, LandmarkSensor::stereo, LandmarkSensor::rgbd}) {
    TestRoad kind;
    kind.sensor = sensor;
    const LandmarkMap map = make_landmark_test_map(kind);
    const fs::path file = scratch_path("road.rastro");
    save_map(map, file);
    EXPECT_EQ(kind_of_map(file), MapKind::landmarks);
    const auto loaded = load_landmark_map(file);
    expect_same(map, *loaded);
    EXPECT_EQ(saved_bytes(*loaded, "again.rastro"), read_whole_file(file)) << "save, load, save";
  }
}

TEST(LandmarkMapFile, AnEmptyMapIsOneToo) {
  LandmarkMap map;
  map.camera = road().camera;
  const fs::path file = scratch_path("empty.rastro");
  save_map(map, file);
  EXPECT_TRUE(load_landmark_map(file)->keyframes.empty());
}

TEST(LandmarkMapFile, SaysWhichKindItIsWhereTheOtherIsNeeded) {
  const fs::path file = scratch_path("road.rastro"), other = scratch_path("room.rastro");
  save_map(road(), file);
  save_map(make_test_map(2), other);
  EXPECT_EQ(kind_of_map(other), MapKind::rgbd);
  EXPECT_THAT(message_of([&] { load_map(file); }), HasSubstr("is a map of landmarks"));
  EXPECT_THAT(message_of([&] { load_landmark_map(other); }), HasSubstr("is a map of a depth camera"));
  EXPECT_EQ(check_map_file(file).version, 2U);
  EXPECT_EQ(check_map_file(other).version, 1U) << "older programs read it";
}

TEST(LandmarkMapFile, RefusesAMapThatContradictsItself) {
  const std::pair<const char*, std::function<void(LandmarkMap&)>> damages[] = {
      {"a keyframe that is not there", [](LandmarkMap& map) { map.landmarks[3].observations[0].keyframe = 5; }},
      {"a feature that is not there", [](LandmarkMap& map) { map.landmarks[3].observations[0].feature = 1 << 20; }},
      {"a ring", [](LandmarkMap& map) { map.poses[0].parent = map.keyframes[3]->id; }},
      {"leads to a keyframe", [](LandmarkMap& map) { map.poses[4].parent = 5; }},
      {"a tie to", [](LandmarkMap& map) { map.ties[0].to = 999; }}};
  for (const auto& [what, damage] : damages) {
    LandmarkMap map = road();
    damage(map);
    EXPECT_THAT(contradiction_in(map), HasSubstr(what));
    const fs::path file = scratch_path("bad.rastro");
    save_map(map, file);
    EXPECT_THAT(message_of([&] { load_landmark_map(file); }), HasSubstr(what));
  }
}

TEST(LandmarkMapFile, NoByteThatMeansSomethingChangesUnseen) {
  TestRoad small;
  small.keyframes = 8, small.landmarks = 600;
  const LandmarkMap map = make_landmark_test_map(small);
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
      EXPECT_EQ(saved_bytes(*report.landmark_map, "resaved.rastro"), whole);
    });
    seen += line != "no error" ? 1 : 0;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
  EXPECT_GT(seen, 10);
}

TEST(RecoverLandmarkMap, SavesAllOfASoundFileAndWhatIsLeftOfADamagedOne) {
  const fs::path file = scratch_path("road.rastro");
  save_map(road(), file);
  const std::string whole = read_whole_file(file);
  const RecoveredMap all = recover_map(file);
  EXPECT_TRUE(all.finished);
  EXPECT_THAT(all.lost, testing::IsEmpty());
  EXPECT_EQ(saved_bytes(*all.landmark_map, "all.rastro"), whole);
  std::string holed = whole;
  holed.replace(0, 4096, 4096, 'x');
  holed.replace(20 * 4096, 2 * 4096, 2 * 4096, 'y');
  holed.resize(whole.size() * 9 / 10 / 4096 * 4096);
  write_whole_file(file, holed);
  const RecoveredMap rest = recover_map(file);
  EXPECT_FALSE(rest.lost.empty());
  EXPECT_GT(rest.landmark_map->keyframes.size(), 5U);
  EXPECT_EQ(contradiction_in(*rest.landmark_map), "");
  const fs::path saved = scratch_path("saved.rastro");
  save_map(*rest.landmark_map, saved);
  EXPECT_EQ(load_landmark_map(saved)->landmarks.size(), rest.landmark_map->landmarks.size());
}

/// The map as it was when it had fewer keyframes.
LandmarkMap younger(std::size_t keyframes) {
  LandmarkMap map = road();
  map.keyframes.resize(keyframes);
  map.poses.resize(keyframes);
  map.ties.clear();
  for (Landmark& landmark : map.landmarks) {
    std::erase_if(landmark.observations,
                  [&](const auto& observation) { return observation.keyframe > map.keyframes.back()->id; });
    landmark.position *= 1.01;
  }
  std::erase_if(map.landmarks, [](const Landmark& landmark) { return landmark.observations.empty(); });
  map.trajectory.resize(map.trajectory.size() / 2);
  return map;
}

TEST(GrowingMapFile, OfLandmarksIsReadableWhereItStopped) {
  const fs::path file = scratch_path("stopped.rastro");
  for (const bool shrinks : {false, true}) {
    const LandmarkMap last = shrinks ? younger(4) : road();
    {
      GrowingMapFile growing(file);
      EXPECT_TRUE(growing.wants_map());
      growing.keep(std::make_shared<LandmarkMap>(shrinks ? road() : younger(7)));
      while (!fs::exists(file.string() + "-wal")) std::this_thread::yield();
      growing.keep(std::make_shared<LandmarkMap>(last));
      EXPECT_FALSE(growing.wants_map());
    }
    const MapFileReport report = check_map_file(file);
    EXPECT_EQ(report.damage, "");
    EXPECT_FALSE(report.finished);
    ASSERT_TRUE(report.landmark_map);
    EXPECT_EQ(saved_bytes(*report.landmark_map, "kept.rastro"), saved_bytes(last, "last.rastro"));
  }
}

TEST(GrowingMapFile, OfLandmarksEndsAsTheFileOfTheMap) {
  const fs::path file = scratch_path("grown.rastro");
  GrowingMapFile growing(file);
  growing.keep(std::make_shared<LandmarkMap>(younger(7)));
  growing.keep(std::make_shared<LandmarkMap>(younger(9)));
  growing.finish(road());
  EXPECT_EQ(read_whole_file(file), saved_bytes(road(), "plain.rastro"));
  EXPECT_FALSE(fs::exists(file.string() + "-wal"));
  GrowingMapFile nowhere(scratch_path("no_folder") / "map.rastro");
  nowhere.keep(std::make_shared<LandmarkMap>(road()));
  EXPECT_THAT(message_of([&] { nowhere.finish(road()); }), HasSubstr("no_folder"));
}

}  // namespace
}  // namespace rastro
