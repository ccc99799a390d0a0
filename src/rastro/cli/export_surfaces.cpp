// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/cli/export_formats.h"
#include "rastro/export/cloud_pcd.h"
#include "rastro/export/grid_map_server.h"
#include "rastro/export/ply.h"
#include "rastro/map/cloud/upright.h"
#include "rastro/map/grid/slice.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/layer_type.h"
#include "rastro/map/mesh/build_mesh.h"
#include "rastro/map/scans/scan_layer.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

/// The up direction, from the floor in a coarse cloud or from the cameras.
Upright upright_of(const ExportJob& job, const Map& map) {
  CloudOptions coarse;
  coarse.voxel_m = 0.04;
  coarse.stride = 8;
  coarse.submap = job.settings.cloud.submap;
  Trajectory cameras;
  for (const Keyframe& keyframe : map.keyframes)
    if (coarse.submap < 0 || keyframe.submap == coarse.submap)
      cameras.push_back({keyframe.stamp, keyframe.world_from_camera});
  const PointCloud cloud = images_of(map) ? build_cloud(map, coarse, &job.pool) : layer_points(map, coarse.submap);
  return find_upright(cloud, cameras);
}

std::string upright_frame(const Upright& upright, ExportFacts& facts) {
  facts["floor_found"] = upright.floor_found;
  facts["upright"] = upright.found_by;
  return "frame: z up, " + upright.found_by;
}

/// Of the layers of a map: in the unit of the map, with viewing directions for normals.
CloudTerms terms_of_layers(const Map& map) {
  return {unit_of(map), "observations", "the position along the mean viewing direction"};
}

/// A map with images, upright if wanted, and what its frame is.
std::pair<Map, std::string> oriented_map(const ExportJob& job, bool upright_wanted, ExportFacts& facts) {
  need_layer<ImageLayer>(job.input, job.settings.to);
  std::pair<Map, std::string> oriented{*job.input.map, "frame: the world of the map"};
  if (!upright_wanted) return oriented;
  const Upright upright = upright_of(job, *job.input.map);
  for (Keyframe& keyframe : oriented.first.keyframes)
    keyframe.world_from_camera = upright.upright_from_world * keyframe.world_from_camera;
  oriented.second = upright_frame(upright, facts);
  return oriented;
}

/// Points of landmarks, semi-dense depth and scans.
std::pair<PointCloud, std::string> oriented_points(const ExportJob& job, ExportFacts& facts) {
  const Map& map = *job.input.map;
  PointCloud cloud = layer_points(map, job.settings.cloud.submap);
  if (cloud.points.empty())
    throw Error("no layer of the map has points", job.input.path, "'rastro info' lists its layers");
  // A map without cameras is one of a plane, with z up.
  if (!job.settings.upright || map.cameras.empty()) return {std::move(cloud), "frame: the world of the map"};
  const Upright upright = upright_of(job, map);
  for (CloudPoint& point : cloud.points) {
    point.position = (upright.upright_from_world * point.position.cast<double>()).cast<float>();
    point.normal = (upright.upright_from_world.rotation() * point.normal.cast<double>()).cast<float>();
  }
  return {std::move(cloud), upright_frame(upright, facts)};
}

ExportFacts write_grid(const ExportJob& job, const OccupancyGrid& grid, const std::string& comment, ExportFacts facts) {
  fs::path image = job.settings.out, yaml = job.settings.out;
  image.replace_extension(".pgm"), yaml.replace_extension(".yaml");
  write_export(image, [&grid](const PutPiece& put) { map_server_pgm(grid, put); });
  write_export(yaml, comment + map_server_yaml(grid, image.filename().string()));
  facts["width"] = grid.width;
  facts["height"] = grid.height;
  facts["cell_m"] = grid.cell_m;
  return facts;
}

ExportFacts export_slice(const ExportJob& job) {
  ExportFacts facts;
  const auto [map, frame] = oriented_map(job, true, facts);
  const OccupancyOctree octree = build_octree(map, job.settings.octree, &job.pool, job.progress);
  const OccupancyGrid grid = slice_between(octree, job.settings.lowest_m, job.settings.highest_m);
  const SE3 upright_from_world =
      map.keyframes.front().world_from_camera * job.input.map->keyframes.front().world_from_camera.inverse();
  const Eigen::Vector3d& t = upright_from_world.translation();
  const Eigen::Quaterniond& q = upright_from_world.rotation().quaternion();
  const std::string comment = fmt::format(
      "# slice from {:g} to {:g} m above the floor; {}\n# this frame from the map's world: x y z {:.6f} {:.6f} {:.6f}, "
      "quaternion x "
      "y z w {:.6f} {:.6f} {:.6f} {:.6f}\n",
      job.settings.lowest_m, job.settings.highest_m, frame, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  return write_grid(job, grid, comment, std::move(facts));
}

}  // namespace

ExportFacts export_cloud(const ExportJob& job) {
  ExportFacts facts;
  PointCloud cloud;
  std::string frame;
  CloudTerms terms;
  if (images_of(need_map(job.input, job.settings.to))) {
    Map map;
    std::tie(map, frame) = oriented_map(job, job.settings.upright, facts);
    cloud = build_cloud(map, job.settings.cloud, &job.pool, job.progress);
  } else {
    std::tie(cloud, frame) = oriented_points(job, facts);
    terms = terms_of_layers(*job.input.map);
  }
  write_export(job.settings.out,
               job.settings.to == "pcd" ? cloud_pcd(cloud, frame, terms) : cloud_ply(cloud, frame, terms));
  facts["points"] = cloud.points.size();
  if (cloud.voxel_m > 0.0) facts["voxel_m"] = cloud.voxel_m;
  return facts;
}

ExportFacts export_mesh(const ExportJob& job) {
  ExportFacts facts;
  const auto [map, frame] = oriented_map(job, job.settings.upright, facts);
  MeshOptions options;
  options.voxel_m = job.settings.voxel_m.value_or(options.voxel_m);
  options.max_depth_m = job.settings.max_depth_m;
  options.submap = job.settings.cloud.submap;
  const TriangleMesh mesh = build_mesh(map, options, &job.pool, job.progress);
  write_export(job.settings.out, mesh_ply(mesh, frame));
  facts["vertices"] = mesh.vertices.size();
  facts["triangles"] = mesh.triangles.size();
  facts["voxel_m"] = options.voxel_m;
  return facts;
}

ExportFacts export_octomap(const ExportJob& job) {
  const std::string extension = fs::path(job.settings.out).extension().string();
  if (extension != ".ot" && extension != ".bt")
    throw Error("an OctoMap is a .ot file (probabilities) or a .bt file (occupied or free)", job.settings.out,
                "give --out FILE.ot or FILE.bt");
  ExportFacts facts;
  const auto [map, frame] = oriented_map(job, job.settings.upright, facts);
  const OccupancyOctree octree = build_octree(map, job.settings.octree, &job.pool, job.progress);
  write_export(job.settings.out, extension == ".ot" ? octree.ot_bytes() : octree.bt_bytes());
  facts["occupied_leaves"] = octree.occupied_leaves();
  facts["free_leaves"] = octree.free_leaves();
  facts["resolution_m"] = octree.resolution_m();
  return facts;
}

ExportFacts export_pgm(const ExportJob& job) {
  const auto grid = occupancy_grid_of(need_map(job.input, "pgm"), std::max(0, job.settings.cloud.submap));
  return grid ? write_grid(job, *grid, "", {}) : export_slice(job);
}

}  // namespace rastro::cli
