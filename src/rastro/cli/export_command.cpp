// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/export_input.h"
#include "rastro/cli/export_landmarks.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/export/cloud_pcd.h"
#include "rastro/export/colmap.h"
#include "rastro/export/grid_map_server.h"
#include "rastro/export/ply.h"
#include "rastro/export/pose_graph_g2o.h"
#include "rastro/export/pose_text.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/cloud/upright.h"
#include "rastro/map/grid/slice.h"
#include "rastro/map/mesh/build_mesh.h"
#include "rastro/map/octree/occupancy_octree.h"
#include "rastro/session/trajectory_text.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* footer =
    R"(RUN is the folder of a run, MAP a map file (map.rastro); poses can also be taken from a trajectory file.
  ply      coloured point cloud with normals, count (measurements) and sigma (m, along the normal); binary
  pcd      the same as the Point Cloud Library reads it
  mesh     surfaces as triangles with colours; PLY
  octomap  occupied and free space as an OctoMap: FILE.ot with probabilities, FILE.bt occupied or free only
  pgm      what stands between two heights, from above: FILE.pgm and FILE.yaml as ROS's map_server reads them
  g2o      pose graph of the keyframes with information matrices
  colmap   folder with cameras.txt, images.txt, points3D.txt and images/
Of a map of landmarks (one camera, two cameras, or --method orb on depth):
  ply      one grey point a landmark: count (sightings) and sigma (along the view); binary
  landmarks  CSV: id, place, sigma, sightings, and the frame and pixel that show it first
  g2o      its essential graph    svg, png  keyframes, landmarks, covisibility and essential graph from above
  colmap   folder with cameras, images (named by frame, such as 000123.png) and points3D; colmap-binary: as .bin
Of both:
  tum, kitti, euroc   poses of all frames; kitti also writes FILE_times.txt
Lengths are in metres, in the world of the map: for a depth camera its first view, x right, y down, z ahead. With
--upright clouds, meshes and octrees stand on the floor: z up, the origin below the first camera, which looks along
x. pgm always does. The floor is the lowest large level plane seen; where there is none, up is the cameras' mean up.

Examples:
  rastro export run --to ply --out room.ply
  rastro export run/map.rastro --to octomap --out room.bt --resolution 0.1 --upright
  rastro export run --to pgm --out floor.yaml --height 0.1:1.5
  rastro export run --to colmap --out colmap)";

struct Flags {
  std::string input, to, out, height, submap = "0";
  CloudOptions cloud;
  OctreeOptions octree;
  std::optional<double> voxel_m;
  std::optional<int> stride;
  double max_depth_m = 5.0;
  double lowest_m = 0.1, highest_m = 1.8;
  bool upright = false, json = false, quiet = false;
  int threads = 0;
};

/// What there is to say of an export, in order.
using Facts = nlohmann::ordered_json;

struct Job {
  const Flags& flags;
  const ExportInput& input;
  TaskPool& pool;
  MapProgress progress;
};

void write_file(const fs::path& file, std::string_view bytes) {
  std::error_code ignored;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), ignored);
  write_whole_file(file, bytes);
}

Upright upright_of(const Job& job, const RgbdMap& map) {
  CloudOptions coarse;
  coarse.voxel_m = 0.04;
  coarse.stride = 8;
  coarse.submap = job.flags.cloud.submap;
  Trajectory cameras;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k)
    if (coarse.submap < 0 || map.poses[k].submap == coarse.submap)
      cameras.push_back({map.keyframes[k]->stamp, map.poses[k].world_from_camera});
  return find_upright(build_cloud(map, coarse, &job.pool), cameras);
}

/// The map with its world turned upright.
RgbdMap stood_up(const RgbdMap& map, const SE3& upright_from_world) {
  RgbdMap turned = map;
  for (KeyframePose& pose : turned.poses) pose.world_from_camera = upright_from_world * pose.world_from_camera;
  for (StampedPose& pose : turned.trajectory) pose.world_from_body = upright_from_world * pose.world_from_body;
  return turned;
}

constexpr const char* camera_world = "frame: the world of the map";
std::string upright_world(const Upright& upright) { return "frame: z up, " + upright.found_by; }

/// The map as asked for, and what its world is.
std::pair<RgbdMap, std::string> oriented_map(const Job& job, bool upright_wanted, Facts& facts) {
  const RgbdMap& map = need_map(job.input, job.flags.to);
  if (!upright_wanted) return {map, camera_world};
  const Upright upright = upright_of(job, map);
  facts["floor_found"] = upright.floor_found;
  facts["upright"] = upright.found_by;
  return {stood_up(map, upright.upright_from_world), upright_world(upright)};
}

Facts export_cloud(const Job& job) {
  Facts facts;
  const auto [map, frame] = oriented_map(job, job.flags.upright, facts);
  const PointCloud cloud = build_cloud(map, job.flags.cloud, &job.pool, job.progress);
  write_file(job.flags.out, job.flags.to == "pcd" ? cloud_pcd(cloud, frame) : cloud_ply(cloud, frame));
  facts["points"] = cloud.points.size();
  facts["voxel_m"] = cloud.voxel_m;
  return facts;
}

Facts export_mesh(const Job& job) {
  Facts facts;
  const auto [map, frame] = oriented_map(job, job.flags.upright, facts);
  MeshOptions options;
  options.voxel_m = job.flags.voxel_m.value_or(options.voxel_m);
  options.max_depth_m = job.flags.max_depth_m;
  options.submap = job.flags.cloud.submap;
  const TriangleMesh mesh = build_mesh(map, options, &job.pool, job.progress);
  write_file(job.flags.out, mesh_ply(mesh, frame));
  facts["vertices"] = mesh.vertices.size();
  facts["triangles"] = mesh.triangles.size();
  facts["voxel_m"] = options.voxel_m;
  return facts;
}

Facts export_octomap(const Job& job) {
  const std::string extension = fs::path(job.flags.out).extension().string();
  if (extension != ".ot" && extension != ".bt")
    throw Error("an OctoMap is a .ot file (probabilities) or a .bt file (occupied or free)", job.flags.out,
                "give --out FILE.ot or FILE.bt");
  Facts facts;
  const auto [map, frame] = oriented_map(job, job.flags.upright, facts);
  const OccupancyOctree octree = build_octree(map, job.flags.octree, &job.pool, job.progress);
  write_file(job.flags.out, extension == ".ot" ? octree.ot_bytes() : octree.bt_bytes());
  facts["occupied_leaves"] = octree.occupied_leaves();
  facts["free_leaves"] = octree.free_leaves();
  facts["resolution_m"] = octree.resolution_m();
  return facts;
}

Facts export_slice(const Job& job) {
  Facts facts;
  const auto [map, frame] = oriented_map(job, true, facts);
  const OccupancyOctree octree = build_octree(map, job.flags.octree, &job.pool, job.progress);
  const OccupancyGrid grid = slice_between(octree, job.flags.lowest_m, job.flags.highest_m);
  fs::path picture = job.flags.out, yaml = job.flags.out;
  picture.replace_extension(".pgm"), yaml.replace_extension(".yaml");
  const SE3 upright_from_world =
      map.poses.front().world_from_camera * job.input.map->poses.front().world_from_camera.inverse();
  const Eigen::Vector3d& t = upright_from_world.translation();
  const Eigen::Quaterniond& q = upright_from_world.rotation().quaternion();
  write_file(picture, map_server_pgm(grid));
  write_file(yaml, fmt::format("# what stands {:g} to {:g} m high; {}\n# this frame from the map's world: x y z {:.6f} "
                               "{:.6f} {:.6f}, quaternion x y z w {:.6f} {:.6f} {:.6f} {:.6f}\n{}",
                               job.flags.lowest_m, job.flags.highest_m, frame, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                               q.w(), map_server_yaml(grid, picture.filename().string())));
  facts["width"] = grid.width;
  facts["height"] = grid.height;
  facts["cell_m"] = grid.cell_m;
  return facts;
}

Facts export_g2o(const Job& job) {
  const RgbdMap& map = need_map(job.input, "g2o");
  write_file(job.flags.out, pose_graph_g2o(map));
  return {{"vertices", map.poses.size()}, {"edges", map.edges.size()}};
}

Facts export_colmap(const Job& job) {
  const RgbdMap& map = need_map(job.input, "colmap");
  write_colmap(map, job.flags.out, job.flags.cloud.submap);
  return {{"keyframes", map.keyframes.size()}};
}

/// Of a map of landmarks; only for what has no other writer here.
Facts export_landmark_kind(const Job& job) {
  Facts facts;
  const LandmarkMap& map = need_landmark_map(job.input, job.flags.to);
  for (const auto& [name, value] : export_landmarks(map, job.flags.to, job.flags.out, job.flags.cloud.submap))
    facts[name] = value;
  return facts;
}

Facts export_poses(const Job& job) {
  const Trajectory& trajectory = need_trajectory(job.input, job.flags.to);
  const fs::path out = job.flags.out;
  if (job.flags.to == "tum") write_file(out, trajectory_text(trajectory, "exported; metres"));
  if (job.flags.to == "euroc") write_file(out, euroc_text(trajectory));
  if (job.flags.to == "kitti") {
    write_file(out, kitti_text(trajectory));
    write_file(out.parent_path() / (out.stem().string() + "_times.txt"), kitti_times_text(trajectory));
  }
  return {{"poses", trajectory.size()}};
}

struct Kind {
  const char* name;
  std::function<Facts(const Job&)> write;
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{{"ply", export_cloud},
                                     {"pcd", export_cloud},
                                     {"mesh", export_mesh},
                                     {"octomap", export_octomap},
                                     {"pgm", export_slice},
                                     {"g2o", export_g2o},
                                     {"colmap", export_colmap},
                                     {"tum", export_poses},
                                     {"kitti", export_poses},
                                     {"euroc", export_poses},
                                     {"landmarks", export_landmark_kind},
                                     {"colmap-binary", export_landmark_kind},
                                     {"svg", export_landmark_kind},
                                     {"png", export_landmark_kind}};
  return all;
}

const Kind& kind_named(const std::string& name) {
  std::vector<std::string> names;
  for (const Kind& kind : kinds()) {
    if (name == kind.name) return kind;
    names.emplace_back(kind.name);
  }
  throw Error("there is no format " + in_quotes(name), "--to",
              fmt::format("did you mean '{}'? Known are {}", nearest_name(name, names), fmt::join(names, ", ")));
}

double checked(double value, double lowest, double highest, const char* flag, const char* unit) {
  if (value >= lowest && value <= highest) return value;
  throw Error(fmt::format("{:g} is out of range", value), flag,
              fmt::format("give {:g} to {:g} {}", lowest, highest, unit));
}

void set_height(Flags& flags) {
  if (flags.height.empty()) return;
  const auto ends = split(flags.height, ':');
  const bool two = ends.size() == 2;
  const double lowest = two ? parse_finite(ends[0]).value_or(NAN) : NAN;
  const double highest = two ? parse_finite(ends[1]).value_or(NAN) : NAN;
  if (!(lowest < highest))
    throw Error(in_quotes(flags.height) + " is no band of heights", "--height", "give A:B in metres, such as 0.1:1.8");
  flags.lowest_m = lowest, flags.highest_m = highest;
}

void settle(Flags& flags) {
  if (flags.voxel_m) flags.cloud.voxel_m = checked(*flags.voxel_m, 0.001, 1.0, "--voxel", "m");
  checked(flags.octree.resolution_m, 0.005, 5.0, "--resolution", "m");
  flags.cloud.max_depth_m = flags.octree.max_range_m = checked(flags.max_depth_m, 0.5, 100.0, "--max-depth", "m");
  if (flags.stride)
    flags.cloud.stride = flags.octree.stride = static_cast<int>(checked(*flags.stride, 1, 64, "--stride", "pixels"));
  const auto submap = parse_int64(flags.submap);
  if (flags.submap != "all" && !(submap && *submap >= 0 && *submap < 1'000'000))
    throw Error(in_quotes(flags.submap) + " is no submap", "--submap", "give its number, or all");
  flags.cloud.submap = flags.octree.submap = flags.submap == "all" ? -1 : static_cast<int>(*submap);
  checked(flags.threads, 0, 1024, "--threads", "");
  set_height(flags);
}

void refuse_input(const Flags& flags) {
  std::error_code ignored;
  for (const fs::path& file : {fs::path(flags.input), fs::path(flags.input) / "map.rastro"})
    if (fs::equivalent(file, flags.out, ignored))
      throw Error("would overwrite what is exported", flags.out, "give another --out");
}

void report(const Flags& flags, const Facts& facts) {
  if (flags.json) {
    Facts all{{"out", flags.out}, {"to", flags.to}};
    all.update(facts);
    fmt::print("{}\n", all.dump(2, ' ', false, Facts::error_handler_t::replace));
  } else if (!flags.quiet) {
    std::string text;
    for (const auto& [name, value] : facts.items())
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name,
                          value.is_string() ? value.get<std::string>() : value.dump());
    fmt::print("{} written to {}: {}\n", flags.to, flags.out, text);
  }
}

void run_export(Flags& flags) {
  const Kind& kind = kind_named(flags.to);
  settle(flags);
  refuse_input(flags);
  const ExportInput input = read_export_input(flags.input);
  TaskPool pool(flags.threads);
  ProgressBar bar(!flags.quiet);
  const bool of_landmarks = input.landmark_map && !std::set<std::string>{"tum", "kitti", "euroc"}.contains(flags.to);
  const std::function<Facts(const Job&)> write = of_landmarks ? export_landmark_kind : kind.write;
  const Facts facts =
      write({flags, input, pool, [&](std::size_t done, std::size_t all) { bar.show_steps("keyframes", done, all); }});
  bar.clear();
  report(flags, facts);
}

}  // namespace

void add_export_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("export", "Write a map or its poses for other programs");
  const auto flags = std::make_shared<Flags>();
  command->add_option("RUN", flags->input, "Folder of a run, or a map file")->required()->type_name("RUN|MAP");
  command
      ->add_option("--to", flags->to,
                   "ply, pcd, mesh, octomap, pgm, g2o, colmap, tum, kitti, euroc, or, of landmarks, landmarks, "
                   "colmap-binary, svg, png")
      ->required()
      ->type_name("FORMAT");
  command->add_option("--out", flags->out, "File to write; for colmap a folder")->required()->type_name("FILE");
  command
      ->add_option("--voxel", flags->voxel_m,
                   "Side of the voxels of ply and pcd (default: 0.01) and mesh (default: 0.02)")
      ->type_name("M");
  command
      ->add_option("--min-count", flags->cloud.min_count,
                   "ply, pcd: leave out points of fewer measurements (default: 3)")
      ->type_name("N");
  command->add_option("--resolution", flags->octree.resolution_m, "octomap, pgm: side of the cubes (default: 0.05)")
      ->type_name("M");
  command
      ->add_option("--height", flags->height, "pgm: what stands between A and B m above the floor (default: 0.1:1.8)")
      ->type_name("A:B");
  command->add_option("--max-depth", flags->max_depth_m, "Leave out what was farther from the camera (default: 5)")
      ->type_name("M");
  command
      ->add_option("--stride", flags->stride,
                   "Every so many-th pixel each way (default: 2; 4 for octomap and pgm; mesh takes all)")
      ->type_name("N");
  command->add_option("--submap", flags->submap, "Number of the submap, or all (default: 0, the first)")
      ->type_name("N|all");
  command->add_flag("--upright", flags->upright, "ply, pcd, mesh, octomap: stand the map on its floor, z up");
  command->add_option("--threads", flags->threads, "Threads; the same bytes for any number (default: all)")
      ->type_name("N");
  command->add_flag("--json", flags->json, "Print JSON");
  command->add_flag("--quiet", flags->quiet, "Print nothing but what goes wrong");
  command->footer(footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    run_export(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
