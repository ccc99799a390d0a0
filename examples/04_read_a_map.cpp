// SPDX-License-Identifier: Apache-2.0
// Reads a map of any method: keyframes, constraints, and the layers that it has.
//   example_04_read_a_map [MAP_FILE]      default: map.rastro, as 03_slam writes it
#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "rastro/base/error.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/scans/scan_layer.h"

namespace {

void print_graph(const rastro::Map& map) {
  fmt::print("made by {}, lengths {}\n", map.method, rastro::scale_of(map).metric ? "in meters" : "up to scale");
  for (const rastro::Keyframe& keyframe : map.keyframes) {
    const Eigen::Vector3d position = keyframe.world_from_camera.translation();
    fmt::print("keyframe {:4} at {:.3f} s: ({:.3f}, {:.3f}, {:.3f})\n", keyframe.id, rastro::to_seconds(keyframe.stamp),
               position.x(), position.y(), position.z());
  }
  fmt::print("{} constraints, {} frames\n", map.constraints.size(), rastro::trajectory_of(map).size());
}

/// A map holds what its method and sensor make: ask for the layers you need.
void print_layers(const rastro::Map& map) {
  if (const auto layer = map.layer<rastro::LandmarkLayer>()) {
    std::size_t observations = 0;
    for (const rastro::Landmark& landmark : layer->landmarks) observations += landmark.observations.size();
    fmt::print("{} landmarks, {} observations\n", layer->landmarks.size(), observations);
  }
  if (const auto grid = rastro::occupancy_grid_of(map)) {  // maps of laser scans
    fmt::print("occupancy grid of {} x {} cells of {} m\n", grid->width, grid->height, grid->cell_m);
  }
  if (map.layer<rastro::ImageLayer>()) {  // maps of a depth camera
    const rastro::PointCloud cloud = rastro::build_cloud(map, {.voxel_m = 0.02});
    fmt::print("{} points of the surfaces\n", cloud.points.size());
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const auto map = rastro::load_map(argc > 1 ? argv[1] : "map.rastro");
  print_graph(*map);
  print_layers(*map);
  return 0;
} catch (const rastro::Error& error) {  // bad input: one plain line
  fmt::print(stderr, "{}\n", error.what());
  return 2;
}
