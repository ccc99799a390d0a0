// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/cloud_scene.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/cli/scene_input.h"
#include "rastro/export/ply.h"
#include "rastro/viewer/build_scene.h"

namespace rastro::cli {
namespace {

bool is_level(const PointCloud& cloud) {
  const float height = cloud.points.front().position.z();
  return std::all_of(cloud.points.begin(), cloud.points.end(),
                     [height](const CloudPoint& each) { return each.position.z() == height; });
}

/// Of `rastro slam`, or of `rastro export` of a map that was not made upright: y is down, as in the first camera.
bool is_of_camera(const std::string& path) {
  std::string head(400, ' ');
  std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.find("written by rastro") != std::string::npos && head.find("z up") == std::string::npos;
}

}  // namespace

NamedScene cloud_scene(const std::string& path, std::size_t most, const TileProgress& tiling) {
  PointCloud cloud = read_cloud_ply(path);
  if (cloud.points.empty()) throw Error("has no points", path, "there is nothing to show");
  ViewScene scene;
  scene.title = scene_name(path);
  scene.method = "PLY";
  scene.metric = true;
  scene.planar = is_level(cloud);
  if (scene.planar || !is_of_camera(path)) scene.up = {0.0, 0.0, 1.0};
  scene.layers.emplace_back(scene_points(std::move(cloud), "cloud", most));
  return in_tiles(std::move(scene), tiling);
}

}  // namespace rastro::cli
