// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "rastro/map/images/image_layer.h"
#include "rastro/map/mesh/build_mesh.h"
#include "rastro/map/octree/occupancy_octree.h"
#include "rastro/map/scans/scan_layer.h"
#include "rastro/viewer/scene_parts.h"

namespace rastro::detail {
namespace {

constexpr std::uint8_t unknown_cell = 255, most_occupied = 254;
// Of a grid in the page: cells, and along a side, as most graphics cards take them.
constexpr double most_cells = 16e6, most_side = 16384.0;

std::uint8_t cell_of(std::int8_t percent) {
  if (percent < 0) return unknown_cell;
  return static_cast<std::uint8_t>((percent * most_occupied + 50) / 100);
}

/// Whether `now` is to be shown in place of `before` where both fall into one cell: the occupied one, and no unknown
/// one.
bool outweighs(std::uint8_t now, std::uint8_t before) {
  return now != unknown_cell && (before == unknown_cell || now > before);
}

/// With `factor` x `factor` cells as one.
SceneGrid coarse_grid(const OccupancyGrid& grid, int factor) {
  SceneGrid scene;
  scene.name = "grid";
  scene.width = (grid.width + factor - 1) / factor;
  scene.height = (grid.height + factor - 1) / factor;
  scene.cell = grid.cell_m * factor;
  scene.origin = {grid.origin.x(), grid.origin.y()};
  scene.cells.assign(static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height), unknown_cell);
  for (int y = 0; y < grid.height; ++y) {
    const std::vector<std::int8_t> row = grid.row(y);
    std::uint8_t* cells = scene.cells.data() + static_cast<std::ptrdiff_t>(y / factor) * scene.width;
    for (int x = 0; x < grid.width; ++x) {
      const std::uint8_t cell = cell_of(row[static_cast<std::size_t>(x)]);
      if (outweighs(cell, cells[x / factor])) cells[x / factor] = cell;
    }
  }
  return scene;
}

/// Voxels and cells in proportion to the depth that the map's sensor measures well.
double ratio_of(const Map& map) { return precise_depth_m(map) / CloudOptions().max_depth_m; }

void add_mesh(const SceneJob& job, ViewScene& scene) {
  constexpr double voxel_m = 0.04;
  MeshOptions options;
  options.voxel_m = voxel_m * ratio_of(job.map);
  options.max_depth_m = precise_depth_m(job.map);
  options.submap = job.options.submap;
  const TriangleMesh mesh = build_mesh(job.map, options, &job.pool, job.progress);
  SceneMesh part;
  part.name = "mesh";
  for (const MeshVertex& vertex : mesh.vertices) {
    append(part.positions, vertex.position.cast<double>());
    part.colors.insert(part.colors.end(), vertex.color.begin(), vertex.color.end());
  }
  for (const auto& corners : mesh.triangles)
    part.triangles.insert(part.triangles.end(), corners.begin(), corners.end());
  if (!part.triangles.empty()) scene.layers.emplace_back(std::move(part));
}

void add_octree(const SceneJob& job, ViewScene& scene) {
  OctreeOptions options;
  options.resolution_m *= ratio_of(job.map);
  options.max_range_m = precise_depth_m(job.map);
  options.submap = job.options.submap;
  const OccupancyOctree octree = build_octree(job.map, options, &job.pool, job.progress);
  SceneCubes cubes;
  cubes.name = "octree";
  for (const OctreeCube& cube : octree.occupied_cubes()) {
    append(cubes.centers, cube.center);
    cubes.sizes.push_back(static_cast<float>(cube.side_m));
  }
  if (!cubes.sizes.empty()) scene.layers.emplace_back(std::move(cubes));
}

}  // namespace

void add_grid(const SceneJob& job, ViewScene& scene) {
  const auto grid = occupancy_grid_of(job.map, std::max(0, job.options.submap));
  if (!grid || grid->width == 0 || grid->height == 0) return;
  const double cells = static_cast<double>(grid->width) * grid->height;
  const double times = std::max(std::sqrt(cells / most_cells), std::max(grid->width, grid->height) / most_side);
  const int factor = std::max(1, static_cast<int>(std::ceil(times)));
  scene.layers.emplace_back(coarse_grid(*grid, factor));
}

void add_surfaces(const SceneJob& job, ViewScene& scene) {
  if (!images_of(job.map)) return;
  if (job.options.mesh) add_mesh(job, scene);
  if (job.options.octree) add_octree(job, scene);
}

}  // namespace rastro::detail
