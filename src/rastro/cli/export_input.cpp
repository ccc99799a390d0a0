// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/export_input.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "rastro/base/error.h"
#include "rastro/base/regular_file.h"
#include "rastro/base/text.h"
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

/// Whether it has a line that is no comment.
bool has_poses(const fs::path& file) {
  require_regular_file(file, largest_text_file_bytes);
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (!trim(line).empty() && !line.starts_with('#')) return true;
  return false;
}

ExportInput read_run(const fs::path& folder) {
  ExportInput input;
  input.path = folder.string();
  const fs::path map = folder / "map.rastro", poses = folder / "trajectory.txt";
  if (is_file(map)) input.map = load_map(map);
  // A killed run has no trajectory.txt, one in which nothing joined the map has no pose in it.
  if (is_file(poses) && (!input.map || has_poses(poses))) {
    input.trajectory = read_trajectory(poses.string());
  } else if (input.map) {
    input.trajectory = trajectory_of(*input.map);
  }
  if (!input.map && input.trajectory.empty())
    throw Error("has neither map.rastro nor trajectory.txt", input.path, "give a run folder or a map file");
  return input;
}

}  // namespace

ExportInput read_export_input(const std::string& path) {
  if (is_folder(path)) return read_run(path);
  if (!is_file(path)) throw Error("does not exist", path, "give a run folder or a map file");
  ExportInput input;
  input.path = path;
  if (is_map_file(path)) {
    input.map = load_map(path);
    input.trajectory = trajectory_of(*input.map);
  } else {
    input.trajectory = read_trajectory(path);
  }
  return input;
}

std::string unit_of(const Map& map) { return scale_of(map).metric ? "meters" : "arbitrary units"; }

std::string unit_of(const ExportInput& input) {
  if (input.map) return unit_of(*input.map);
  const fs::path file = is_folder(input.path) ? fs::path(input.path) / "trajectory.txt" : fs::path(input.path);
  if (!is_file(file)) return "unit unknown";
  std::ifstream stream(file);
  std::string comment;
  std::getline(stream, comment);
  const auto unit = comment.rfind("; ");  // as all callers of trajectory_text() pass it
  const bool known = comment.starts_with("# ") && unit != std::string::npos;
  return known ? one_line(comment.substr(unit + 2)) : "unit unknown";
}

const Map& need_map(const ExportInput& input, const std::string& kind) {
  if (input.map && !input.map->keyframes.empty()) return *input.map;
  if (input.map) throw Error("the map has no keyframes", input.path, "there is nothing to export as " + kind);
  const bool planar = is_file(fs::path(input.path) / "map.yaml");
  throw Error("has no map file (map.rastro), which " + kind + " needs", input.path,
              planar ? "its 2D map is map.pgm with map.yaml; export poses with --to tum, kitti or euroc"
                     : "'rastro slam DATA --method NAME' makes one; export poses with --to tum, kitti or euroc");
}

void refuse_without_layer(const std::string& path, const std::string& layer, const std::string& kind) {
  const std::map<std::string, const char*> makers = {{"images", "rgbd"},
                                                     {"features", "orb or rgbd"},
                                                     {"landmarks", "orb"},
                                                     {"scans", "hector"},
                                                     {"signatures", "rtabmap"}};
  const auto maker = makers.find(layer);
  throw Error(fmt::format("the map has no layer '{}', which {} needs", layer, kind), path,
              maker == makers.end() ? "'rastro info' lists its layers"
                                    : fmt::format("'rastro slam DATA --method {}' makes a map with it", maker->second));
}

const Trajectory& need_trajectory(const ExportInput& input, const std::string& kind) {
  if (input.trajectory.empty()) throw Error("has no frame poses", input.path, "--to " + kind + " needs them");
  return input.trajectory;
}

}  // namespace rastro::cli
