// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/export_input.h"

#include <fmt/format.h>

#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/map/file/map_file.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

void read_map(ExportInput& input, const fs::path& file) {
  if (kind_of_map(file) == MapKind::landmarks)
    input.landmark_map = load_landmark_map(file);
  else
    input.map = load_map(file);
}

ExportInput read_run(const fs::path& folder) {
  ExportInput input;
  input.path = folder.string();
  const fs::path map = folder / "map.rastro", poses = folder / "trajectory.txt";
  if (is_file(map)) read_map(input, map);
  if (is_file(poses)) input.trajectory = read_trajectory(poses.string());
  if (!input.map && !input.landmark_map && input.trajectory.empty())
    throw Error("holds neither map.rastro nor trajectory.txt", input.path, "give the folder of a run, or a map file");
  return input;
}

}  // namespace

ExportInput read_export_input(const std::string& path) {
  if (is_folder(path)) return read_run(path);
  if (!is_file(path)) throw Error("does not exist", path, "give the folder of a run, or a map file");
  ExportInput input;
  input.path = path;
  if (is_map_file(path)) {
    read_map(input, path);
    input.trajectory = input.map ? input.map->trajectory : input.landmark_map->trajectory;
  } else {
    input.trajectory = read_trajectory(path);
  }
  return input;
}

const RgbdMap& need_map(const ExportInput& input, const std::string& kind) {
  if (input.map && !input.map->keyframes.empty()) return *input.map;
  if (input.map) throw Error("the map has no keyframes", input.path, "there is nothing to export as " + kind);
  if (input.landmark_map)
    throw Error("is a map of landmarks, and " + kind + " is made from one of a depth camera", input.path,
                "'--to ply' writes the landmarks; 'rastro slam DATA --method rgbd' makes the other kind");
  const bool planar = is_file(fs::path(input.path) / "map.yaml");
  throw Error("has no map of a depth camera (map.rastro), which " + kind + " is made from", input.path,
              planar ? "its 2D map is map.pgm with map.yaml; poses can be had with --to tum, kitti or euroc"
                     : "'rastro slam DATA --method rgbd' makes one; poses can be had with --to tum, kitti or euroc");
}

const LandmarkMap& need_landmark_map(const ExportInput& input, const std::string& kind) {
  if (input.landmark_map && !input.landmark_map->keyframes.empty()) return *input.landmark_map;
  if (input.landmark_map) throw Error("the map has no keyframes", input.path, "there is nothing to export as " + kind);
  throw Error("has no map of landmarks (map.rastro), which " + kind + " is made from", input.path,
              "'rastro slam DATA --method orb' makes one");
}

const Trajectory& need_trajectory(const ExportInput& input, const std::string& kind) {
  if (input.trajectory.empty()) throw Error("has no poses of frames", input.path, "--to " + kind + " writes those");
  return input.trajectory;
}

}  // namespace rastro::cli
