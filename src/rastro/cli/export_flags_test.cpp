// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/export_flags.h"

#include <gtest/gtest.h>

#include "rastro/base/error.h"
#include "rastro/map/images/room_map_testing.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/landmarks/landmark_map_testing.h"
#include "rastro/map/scans/scan_layer.h"

namespace rastro::cli {
namespace {

enum class Kind { poses, images, landmarks, scans };

ExportInput input_of(Kind kind) {
  ExportInput input;
  if (kind == Kind::images) input.map = std::make_shared<const Map>(make_test_map(2));
  if (kind == Kind::landmarks) input.map = std::make_shared<const Map>(make_landmark_test_map());
  if (kind == Kind::scans) {
    auto map = std::make_shared<Map>();
    map->layers.put<ScanLayer>(std::make_shared<ScanLayer>());
    input.map = std::move(map);
  }
  return input;
}

std::string refusal(const std::string& flag, const std::string& to, Kind kind) {
  try {
    refuse_unused_flags({"--out", flag}, to, input_of(kind));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ExportFlags, ThoseThatTheFormatDoesNotUseAreRefused) {
  EXPECT_EQ(refusal("--voxel", "ply", Kind::images), "");
  EXPECT_EQ(refusal("--voxel", "g2o", Kind::images),
            "--voxel: does not apply to --to g2o of a map with images; omit it");
  EXPECT_EQ(refusal("--voxel", "ply", Kind::landmarks),
            "--voxel: does not apply to --to ply of a map of landmarks; omit it");
  EXPECT_EQ(refusal("--voxel", "ply", Kind::scans), "--voxel: does not apply to --to ply of a map of scans; omit it");
  EXPECT_EQ(refusal("--submap", "tum", Kind::poses), "--submap: does not apply to --to tum of poses; omit it");
}

std::string refusal_of_all(const std::string& to, Kind kind) {
  try {
    refuse_all_submaps(to, input_of(kind));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ExportFlags, AllSubmapsAreRefusedWhereOneIsWritten) {
  const auto said = [](const std::string& to) {
    return "--submap all: --to " + to +
           " holds one submap: each is in a frame of its own; give a number; 'rastro info' "
           "lists them";
  };
  for (const char* to : {"tum", "kitti", "euroc"}) EXPECT_EQ(refusal_of_all(to, Kind::landmarks), said(to));
  EXPECT_EQ(refusal_of_all("pgm", Kind::scans), said("pgm"));
  EXPECT_EQ(refusal_of_all("pgm", Kind::images), "") << "a slice of the surfaces of all";
  EXPECT_EQ(refusal_of_all("ply", Kind::scans), "");
}

TEST(ExportFlags, PagesTakeTheirOwn) {
  for (const Kind kind : {Kind::images, Kind::landmarks, Kind::scans}) {
    for (const char* to : {"html", "mcap"}) {
      EXPECT_EQ(refusal("--points", to, kind), "");
      EXPECT_EQ(refusal("--submap", to, kind), "");
    }
    EXPECT_NE(refusal("--points", "ply", kind), "");
    EXPECT_NE(refusal("--voxel", "html", kind), "");
  }
  EXPECT_EQ(refusal("--mesh", "html", Kind::images), "");
  EXPECT_NE(refusal("--octree", "html", Kind::scans), "");
  EXPECT_EQ(refusal("--objects", "html", Kind::images), "");
  EXPECT_NE(refusal("--objects", "html", Kind::landmarks), "");
}

TEST(ExportFlags, LandmarkMapsTakeTheirOwn) {
  for (const char* flag : {"--min-count", "--max-depth"}) {
    for (const char* to : {"ply", "pcd", "colmap", "landmarks", "g2o", "png"})
      EXPECT_EQ(refusal(flag, to, Kind::landmarks), "") << flag << ' ' << to;
    EXPECT_NE(refusal(flag, "tum", Kind::landmarks), "") << flag;
    EXPECT_NE(refusal(flag, "ply", Kind::scans), "") << flag;
  }
  EXPECT_EQ(refusal("--images", "colmap", Kind::landmarks), "");
  EXPECT_EQ(refusal("--images", "mcap", Kind::landmarks), "");
  EXPECT_NE(refusal("--images", "mcap", Kind::images), "") << "they are in the map";
  EXPECT_NE(refusal("--images", "ply", Kind::landmarks), "");
  EXPECT_NE(refusal("--images", "colmap", Kind::images), "");
}

TEST(ExportFlags, EveryKindOfMapHasItsSubmapsAndItsUpright) {
  for (const Kind kind : {Kind::images, Kind::landmarks, Kind::scans}) {
    EXPECT_EQ(refusal("--submap", "g2o", kind), "");
    EXPECT_EQ(refusal("--upright", "ply", kind), "");
    EXPECT_NE(refusal("--upright", "g2o", kind), "");
  }
}

TEST(ExportFlags, ChosenLandmarksHaveEnoughObservationsAndAreNear) {
  const Map map = make_landmark_test_map();
  const auto count = [&](std::size_t min_count, double max_depth) {
    return with_landmarks_within(map, min_count, max_depth)->layer<LandmarkLayer>()->landmarks.size();
  };
  std::size_t often = 0;
  for (const Landmark& landmark : map.layer<LandmarkLayer>()->landmarks)
    often += landmark.observations.size() >= 3 ? 1U : 0U;
  EXPECT_EQ(count(1, 1e9), map.layer<LandmarkLayer>()->landmarks.size());
  EXPECT_EQ(count(3, 1e9), often);
  EXPECT_LT(often, count(1, 1e9)) << "there must be some to leave out";
  EXPECT_EQ(count(1, 0.001), 0U);
  EXPECT_GT(count(1, 6.0), 0U);
  EXPECT_LT(count(1, 6.0), count(1, 1e9));
}

}  // namespace
}  // namespace rastro::cli
