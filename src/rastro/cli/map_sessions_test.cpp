// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/map_sessions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rastro/base/append_file.h"
#include "rastro/base/scratch_testing.h"
#include "rastro/cli/describe_map.h"
#include "rastro/cli/export_input.h"
#include "rastro/cli/recording_of_run.h"
#include "rastro/map/file/map_file.h"

namespace rastro::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

MapSession session_of(int session, int first_s, int last_s, const std::string& recording = "") {
  return {0, session, recording, first_s * ns_per_second, last_s * ns_per_second, {true, 0.0, "depth camera"}};
}

void add_keyframe(Map& map, KeyframeId id, int stamp_s, int submap) {
  Keyframe keyframe;
  keyframe.id = id;
  keyframe.stamp = stamp_s * ns_per_second;
  keyframe.submap = submap;
  map.keyframes.push_back(keyframe);
}

/// Two sessions, the second with one recording as before; keyframes numbered on.
Map numbered_on() {
  Map map;
  map.method = "rtabmap";
  map.sessions = {session_of(0, 10, 20, "first"), session_of(1, 10, 20), session_of(2, 50, 60, "third")};
  KeyframeId id = 0;
  for (const int stamp_s : {10, 15, 20}) add_keyframe(map, id++, stamp_s, stamp_s == 20 ? 1 : 0);
  for (const int stamp_s : {10, 20}) add_keyframe(map, id++, stamp_s, 1);
  add_keyframe(map, id++, 51, 2);
  return map;
}

TEST(MapSessions, KeyframesNumberedOnBelongToSessionsByTheirStamps) {
  const auto shares = session_shares(numbered_on());
  ASSERT_EQ(shares.size(), 3U);
  EXPECT_EQ(shares[0].keyframes, 3U);
  EXPECT_THAT(shares[0].submaps, ElementsAre(0, 1));
  EXPECT_EQ(shares[1].keyframes, 2U);
  EXPECT_THAT(shares[1].submaps, ElementsAre(1));
  EXPECT_EQ(shares[2].keyframes, 1U);
  EXPECT_THAT(shares[2].submaps, ElementsAre(2));
}

TEST(MapSessions, NoTwoKeyframesOfASessionHaveOneStamp) {
  Map map;
  map.sessions = {session_of(0, 10, 20), session_of(1, 10, 20)};
  for (const KeyframeId id : {0, 1}) add_keyframe(map, id, 10, static_cast<int>(id));
  EXPECT_EQ(session_shares(map)[1].keyframes, 1U);
}

TEST(MapSessions, ASessionWithoutKeyframesHasNone) {
  Map map = numbered_on();
  std::erase_if(map.keyframes, [](const Keyframe& keyframe) { return keyframe.id == 3 || keyframe.id == 4; });
  const auto shares = session_shares(map);
  EXPECT_EQ(shares[1].keyframes, 0U);
  EXPECT_EQ(shares[2].keyframes, 1U);
  EXPECT_EQ(session_text(map.sessions[1], shares[1]), "10.000 .. 20.000 s, 0 keyframes");
  EXPECT_TRUE(session_shares(Map()).empty());
}

TEST(MapSessions, AnIdThatNamesTheSessionDecides) {
  Map map;
  map.sessions = {session_of(0, 10, 20), session_of(1, 10, 20)};
  add_keyframe(map, 0, 10, 0);
  add_keyframe(map, keyframe_id({0, 1, 0}), 15, 1);
  add_keyframe(map, keyframe_id({0, 1, 1}), 16, 1);
  const auto shares = session_shares(map);
  EXPECT_EQ(shares[0].keyframes, 1U);
  EXPECT_EQ(shares[1].keyframes, 2U);
}

TEST(MapSessions, InfoHasOneLineForEach) {
  MapFileReport report;
  report.map = std::make_shared<const Map>(numbered_on());
  const std::string text = describe_map(report, "map.rastro");
  EXPECT_THAT(text, HasSubstr("  session 0   10.000 .. 20.000 s, 3 keyframes in submaps 0, 1, of first\n"
                              "  session 1   10.000 .. 20.000 s, 2 keyframes in submap 1\n"
                              "  session 2   50.000 .. 60.000 s, 1 keyframe in submap 2, of third\n"));
  const std::string json = describe_map_json(report, "map.rastro");
  EXPECT_THAT(json, HasSubstr("\"sessions\": 3"));
  EXPECT_THAT(json, HasSubstr("\"recording\": \"third\""));
  EXPECT_THAT(json, HasSubstr("\"first_stamp_s\": 50.0"));
  Map single = numbered_on();
  single.sessions.resize(1);
  report.map = std::make_shared<const Map>(single);
  EXPECT_THAT(describe_map(report, "map.rastro"), Not(HasSubstr("session 0")));
}

TEST(MapRecordings, EachSessionHasItsOwn) {
  const std::filesystem::path folder = scratch_folder("sessions");
  write_whole_file((folder / "first").string(), "");
  Map map = numbered_on();
  map.sessions[0].recording = (folder / "first").string();
  const auto all = recordings_of_map(map, folder.string(), "");
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].recording.path, (folder / "first").string());
  EXPECT_THAT(all[0].keyframes, ElementsAre(0, 1, 2));
  EXPECT_EQ(all[2].recording.path, "") << "gone";
  EXPECT_EQ(all[2].named, "third");
  EXPECT_THAT(all[2].keyframes, ElementsAre(5));
  const auto given = recordings_of_map(map, folder.string(), "given");
  ASSERT_EQ(given.size(), 1U);
  EXPECT_EQ(given[0].recording.path, "given");
  EXPECT_EQ(given[0].keyframes.size(), map.keyframes.size());
}

TEST(ExportInput, ARunThatJoinedNoMapHasThePosesOfTheMap) {
  const std::filesystem::path folder = scratch_folder("sessions");
  Map map;
  map.method = "orb";
  map.cameras.emplace_back().intrinsics = {64, 48, 50.0, 50.0, 32.0, 24.0};
  add_keyframe(map, 0, 10, 0);
  map.frames.push_back({10 * ns_per_second, 0, SE3()});
  save_map(map, (folder / "map.rastro").string());
  write_whole_file((folder / "trajectory.txt").string(), "# world_from_body; meters\n");
  EXPECT_EQ(read_export_input(folder.string()).trajectory.size(), 1U);
  std::filesystem::remove(folder / "trajectory.txt");
  EXPECT_EQ(read_export_input(folder.string()).trajectory.size(), 1U) << "of a killed run";
}

TEST(MapRecordings, AReferenceIsOfTheSessionInWhoseRecordingItIs) {
  const std::filesystem::path folder = scratch_folder("references");
  for (const char* name : {"first", "first_again", "third"}) std::filesystem::create_directories(folder / name);
  Map map = numbered_on();
  map.sessions[0].recording = (folder / "first").string();
  map.sessions[1].recording = (folder / "first" / "").string();
  map.sessions[2].recording = (folder / "third").string();
  EXPECT_EQ(session_of_reference(map, folder, folder / "third" / "groundtruth.txt"), 2U);
  EXPECT_EQ(session_of_reference(map, folder, folder / "third"), 2U);
  EXPECT_EQ(session_of_reference(map, folder, folder / "third" / ".." / "first" / "poses.txt"), 1U) << "the last one";
  EXPECT_EQ(session_of_reference(map, folder, folder / "first_again"), std::nullopt);
  EXPECT_EQ(session_of_reference(map, folder, folder), std::nullopt);
}

TEST(MapSessions, InfoCountsThePosesOfAllThatOverlap) {
  MapFileReport report;
  Map map = numbered_on();
  for (const int stamp_s : {10, 20, 10, 15, 18}) map.frames.push_back({stamp_s * ns_per_second, 0, SE3()});
  report.map = std::make_shared<const Map>(map);
  EXPECT_THAT(describe_map(report, "map.rastro"), HasSubstr("5 poses in 18.0 s"));
}

}  // namespace
}  // namespace rastro::cli
