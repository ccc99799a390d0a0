// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/export_flags.h"
#include "rastro/cli/export_formats.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/export/landmark_export.h"
#include "rastro/map/graph/sessions.h"
#include "rastro/map/images/image_layer.h"
#include "rastro/map/mesh/build_mesh.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* export_footer =
    R"(RUN is a run folder or a map file (map.rastro); poses can also be taken from a trajectory file.
All maps:
  html     one page with everything there is to see, which opens in a browser without a server or a network: trajectory,
           keyframes and their graphs, landmarks, cloud, semi-dense points, scans, occupancy grid; of a run folder also
           states, times, events, uncertainties and errors. Also of poses alone. 'rastro view' shows the same
  mcap     the same for Foxglove, Lichtblick and Rerun, over the time of the recording, with images of the keyframes where
           they are in the map or in a recording that is there; messages are those of Foxglove's Protobuf schemas
  ply      point cloud; binary. rgbd: colored surfaces with normals, count (measurements) and sigma (standard deviation
           along the normal). Others: landmarks (gray; count: observations, sigma: along the mean viewing direction),
           semi-dense depth and scans. An unknown sigma is nan
  pcd      the same for the Point Cloud Library
  g2o      pose graph of the keyframes with information matrices; orb: the essential graph
  pgm      FILE.pgm and FILE.yaml of ROS map_server: occupancy grid of the laser, or a slice between two heights (rgbd)
  tum, kitti, euroc   poses of all frames; kitti also writes FILE_times.txt. Of a map file those of all its sessions, but
           where these overlap in time, as with clocks that begin at 0, those of the last one alone (html and mcap, too)
rgbd and orb:
  colmap   folder with cameras.txt, images.txt, points3D.txt and images/; orb: the images are those of the recording, by
           their own names, and landmarks observed once are omitted
rgbd:
  mesh     colored triangle mesh; PLY
  octomap  occupied and free space: FILE.ot with probabilities, FILE.bt binary
orb:
  landmarks  CSV: id, position, sigma (empty: unknown), observations, frame and pixel of the first observation
  svg, png   keyframes, landmarks, covisibility and essential graph from above
  colmap-binary   as colmap, .bin
rtabmap:
  word-images  folder with a picture of each location, ID.jpg: its visual words (green: new, yellow: several times in
           this image, red: in the vocabulary, blue: in the previous image, pink: shared with the matched location) and
           the location that it closed a loop with
lsd:
  depth-images  folder with a picture of each keyframe, ID.jpg: its pixels with gradient and their inverse depths from
           blue (far) to red (near), and twelve of them in strip.png
  depth-video   the same as a video in real time, .mp4 or .avi
Lengths are in meters, or up to scale in a map of one camera without 'rastro scale'; formats with comments say which. The
frame is the world of the map; for cameras the first camera: x right, y down, z ahead. With --upright clouds, meshes and
octrees are level: z up, origin on the floor below the first camera, which looks along x; a slice always is. The floor is
the lowest large horizontal plane; without one, up is the mean up direction of the cameras.

Examples:
  rastro export run --to html --out room.html
  rastro export run --to mcap --out room.mcap
  rastro export run --to ply --out room.ply
  rastro export run/map.rastro --to octomap --out room.bt --resolution 0.1 --upright
  rastro export run --to pgm --out floor.yaml --height 0.1:1.5
  rastro export run --to colmap --out colmap)";

struct ExportFlags {
  ExportSettings settings;
  std::string input, height, submap = "0";
  std::vector<std::string> given;  ///< ExportFlags given on the command line.
  std::optional<int> stride;
  bool json = false, quiet = false;
  int threads = 0;
};

struct Format {
  const char* name;
  ExportFacts (*write)(const ExportJob&);
};

constexpr Format formats[] = {{"html", export_html},
                              {"mcap", export_mcap},
                              {"ply", export_cloud},
                              {"pcd", export_cloud},
                              {"mesh", export_mesh},
                              {"octomap", export_octomap},
                              {"pgm", export_pgm},
                              {"g2o", export_g2o},
                              {"colmap", export_colmap},
                              {"tum", export_poses},
                              {"kitti", export_poses},
                              {"euroc", export_poses},
                              {"landmarks", export_landmark_list},
                              {"colmap-binary", export_colmap},
                              {"svg", export_image},
                              {"png", export_image},
                              {"word-images", export_word_images},
                              {"depth-images", export_depth_images},
                              {"depth-video", export_depth_video}};

const Format& format_named(const std::string& name) {
  std::vector<std::string> names;
  for (const Format& format : formats) {
    if (name == format.name) return format;
    names.emplace_back(format.name);
  }
  throw Error(in_quotes(name) + " is not a format", "--to",
              did_you_mean(name, names, fmt::format("formats are {}", fmt::join(names, ", "))));
}

double checked(double value, double lowest, double highest, const char* flag, const char* unit) {
  if (value >= lowest && value <= highest) return value;
  throw Error(fmt::format("{:g} is out of range", value), flag,
              fmt::format("give {:g} to {:g} {}", lowest, highest, unit));
}

void set_height(ExportFlags& flags) {
  if (flags.height.empty()) return;
  const auto ends = split(flags.height, ':');
  const bool two = ends.size() == 2;
  const double lowest = two ? parse_finite(ends[0]).value_or(NAN) : NAN;
  const double highest = two ? parse_finite(ends[1]).value_or(NAN) : NAN;
  if (!(lowest < highest))
    throw Error(in_quotes(flags.height) + " is not a range of heights", "--height",
                "give A:B in meters, such as 0.1:1.8");
  flags.settings.lowest_m = lowest, flags.settings.highest_m = highest;
}

void settle(ExportFlags& flags) {
  ExportSettings& settings = flags.settings;
  if (settings.voxel_m) settings.cloud.voxel_m = checked(*settings.voxel_m, 0.001, 1.0, "--voxel", "m");
  checked(settings.octree.resolution_m, 0.005, 5.0, "--resolution", "m");
  settings.cloud.max_depth_m = settings.octree.max_range_m =
      checked(settings.max_depth_m, 0.5, 100.0, "--max-depth", "m");
  if (flags.stride)
    settings.cloud.stride = settings.octree.stride =
        static_cast<int>(checked(*flags.stride, 1, 64, "--stride", "pixels"));
  const auto submap = parse_int64(flags.submap);
  if (flags.submap != "all" && !(submap && *submap >= 0 && *submap < 1'000'000))
    throw Error(in_quotes(flags.submap) + " is not a submap", "--submap", "give a number, or all");
  settings.cloud.submap = settings.octree.submap = flags.submap == "all" ? -1 : static_cast<int>(*submap);
  checked(flags.threads, 0, 1024, "--threads", "");
  set_height(flags);
}

void settle_out(ExportFlags& flags) {
  std::string& out = flags.settings.out;
  if (!out.empty()) return;
  const std::string& to = flags.settings.to;
  if (to != "html" && to != "mcap") throw Error("is missing", "--out", "give the output file");
  out = scene_name(flags.input) + "." + to;
}

void refuse_input(const ExportFlags& flags) {
  std::error_code ignored;
  for (const fs::path& file : {fs::path(flags.input), fs::path(flags.input) / "map.rastro"})
    if (fs::equivalent(file, flags.settings.out, ignored))
      throw Error("would overwrite the input", flags.settings.out, "give another --out");
}

bool is_given(const ExportFlags& flags, const char* flag) {
  return std::find(flags.given.begin(), flags.given.end(), flag) != flags.given.end();
}

/// What is not given follows the depth that the map's sensor measures well.
void fit_to_sensor(ExportFlags& flags, const ExportInput& input) {
  if (!input.map || !input.map->layer<ImageLayer>()) return;
  ExportSettings& settings = flags.settings;
  const CloudOptions fitting = cloud_options_for(*input.map);
  const double ratio = fitting.max_depth_m / CloudOptions().max_depth_m;
  if (ratio == 1.0) return;
  if (!is_given(flags, "--max-depth"))
    settings.max_depth_m = settings.cloud.max_depth_m = settings.octree.max_range_m = fitting.max_depth_m;
  if (!is_given(flags, "--resolution")) settings.octree.resolution_m *= ratio;
  if (is_given(flags, "--voxel")) return;
  settings.cloud.voxel_m = fitting.voxel_m;
  settings.voxel_m = MeshOptions().voxel_m * ratio;
}

void report(const ExportFlags& flags, const ExportFacts& facts) {
  const std::string &to = flags.settings.to, &out = flags.settings.out;
  if (flags.json) {
    ExportFacts all{{"out", out}, {"to", to}};
    all.update(facts);
    fmt::print("{}\n", all.dump(2, ' ', false, ExportFacts::error_handler_t::replace));
  } else if (!flags.quiet) {
    std::string text;
    for (const auto& [name, value] : facts.items())
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name,
                          value.is_string() ? value.get<std::string>() : value.dump());
    fmt::print("{} written to {}: {}\n", to, out, text);
  }
}

/// With the landmarks and poses that --submap, --min-count and --max-depth select.
ExportInput chosen_input(const ExportFlags& flags) {
  ExportInput input = read_export_input(flags.input);
  refuse_unused_flags(flags.given, flags.settings.to, input);
  const auto given = [&](const char* flag) { return is_given(flags, flag); };
  if (!input.map) return input;
  const int submap = flags.settings.cloud.submap;
  if (submap < 0) refuse_all_submaps(flags.settings.to, input);
  if (given("--submap")) {
    const auto& keyframes = input.map->keyframes;
    const bool there = std::any_of(keyframes.begin(), keyframes.end(),
                                   [submap](const Keyframe& each) { return each.submap == submap; });
    if (submap >= 0 && !there) throw Error(fmt::format("there is no submap {}", submap), "--submap", "");
    if (submap >= 0) input.trajectory = trajectory_of(*input.map, submap);
  }
  const bool fewer = given("--min-count") || given("--max-depth");
  if (fewer && !input.map->layer<ImageLayer>() && has_observed_landmarks(*input.map))
    input.map = with_landmarks_within(*input.map, given("--min-count") ? flags.settings.cloud.min_count : 0,
                                      given("--max-depth") ? flags.settings.max_depth_m : 1e300);
  return input;
}

void warn_of_overlap(const ExportFlags& flags, const ExportInput& input) {
  const std::vector<std::string> of_poses = {"html", "mcap", "tum", "kitti", "euroc"};
  const bool has_poses = std::find(of_poses.begin(), of_poses.end(), flags.settings.to) != of_poses.end();
  if (has_poses && input.map && sessions_overlap(*input.map))
    log_warning(one_line(input.path) +
                ": its sessions overlap in time; the poses of frames are those of the last one alone");
}

void run_export(ExportFlags& flags) {
  const Format& format = format_named(flags.settings.to);
  settle(flags);
  settle_out(flags);
  refuse_input(flags);
  const ExportInput input = chosen_input(flags);
  fit_to_sensor(flags, input);
  warn_of_overlap(flags, input);
  TaskPool pool(flags.threads);
  ProgressBar bar(!flags.quiet);
  const ExportFacts facts = format.write({flags.settings, input, pool, [&](std::size_t done, std::size_t all) {
                                            bar.show_steps("keyframes", done, all);
                                          }});
  bar.clear();
  if (const auto points = facts.find("points"); points != facts.end() && *points == 0)
    log_warning(flags.settings.out +
                " has no points: the map has none that --submap, --min-count and --max-depth let through");
  report(flags, facts);
}

void add_output_flags(CLI::App& command, ExportFlags& flags) {
  command.add_option("RUN", flags.input, "Run folder or map file")->required()->type_name("");
  command
      .add_option(
          "--to", flags.settings.to,
          "html, mcap, ply, pcd, mesh, octomap, pgm, g2o, colmap, colmap-binary, landmarks, svg, png, word-images, "
          "depth-images, depth-video, tum, kitti, euroc")
      ->required()
      ->type_name("FORMAT");
  command
      .add_option(
          "--out", flags.settings.out,
          "Output file; colmap, word-images, depth-images: folder (default: none; html, mcap: NAME.html, NAME.mcap)")
      ->type_name("FILE");
}

void add_surface_flags(CLI::App& command, ExportFlags& flags) {
  command
      .add_option("--voxel", flags.settings.voxel_m,
                  "ply, pcd, mesh: voxel size in meters (default: 0.01; mesh: 0.02; of a stereo pair in proportion to "
                  "its depth)")
      ->type_name("M");
  command
      .add_option("--min-count", flags.settings.cloud.min_count,
                  "Omit points with fewer measurements (ply, pcd of rgbd; default: 3), landmarks with fewer "
                  "observations (orb; default: 0)")
      ->type_name("N");
  command
      .add_option("--resolution", flags.settings.octree.resolution_m,
                  "octomap, pgm: cell size in meters (default: 0.05)")
      ->type_name("M");
  command.add_option("--height", flags.height, "pgm: heights above the floor in meters (default: 0.1:1.8)")
      ->type_name("A:B");
  command
      .add_option("--max-depth", flags.settings.max_depth_m,
                  "Maximum depth in meters (rgbd; default: 5; of a stereo pair as far as sigma is below 3 % of the "
                  "depth; orb: no limit)")
      ->type_name("M");
  command
      .add_option("--stride", flags.stride,
                  "Use every N-th pixel and row (default: 2; octomap, pgm: 4; mesh: always 1)")
      ->type_name("N");
}

void add_page_flags(CLI::App& command, ExportFlags& flags) {
  command
      .add_option("--points", flags.settings.scene.points,
                  "html, mcap: maximum number of points of each layer (default: 300000; mcap: 1000000)")
      ->type_name("N");
  command.add_flag("--mesh", flags.settings.scene.mesh, "html of rgbd: show surfaces as triangles, too");
  command.add_flag("--octree", flags.settings.scene.octree, "html of rgbd: show occupied space as cubes, too");
  command
      .add_option("--objects", flags.settings.scene.objects,
                  "html of rgbd: lengths to measure and show, as of 'rastro measure'")
      ->type_name("FILE");
}

void add_other_flags(CLI::App& command, ExportFlags& flags) {
  command
      .add_option("--images", flags.settings.images,
                  "colmap of orb, mcap of orb and lsd: recording with the images (default: that of the run)")
      ->type_name("DATA");
  command
      .add_option("--submap", flags.submap,
                  "Submap (default: 0, the first); all: not for tum, kitti, euroc, pgm of scans")
      ->type_name("N|all");
  command.add_flag("--upright", flags.settings.upright,
                   "ply, pcd, mesh, octomap: level the map, z up, origin on the floor");
  command
      .add_option("--threads", flags.threads, "Number of threads; the bytes do not depend on it (default: all cores)")
      ->type_name("N");
  command.add_flag("--json", flags.json, "Print the result as JSON");
  command.add_flag("--quiet", flags.quiet, "Print errors and warnings only");
}

}  // namespace

void add_export_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("export", "Exports a map or its trajectory to other formats");
  const auto flags = std::make_shared<ExportFlags>();
  add_output_flags(*command, *flags);
  add_surface_flags(*command, *flags);
  add_page_flags(*command, *flags);
  add_other_flags(*command, *flags);
  command->footer(export_footer);
  command->callback([command, flags, &context] {
    for (const char* flag : {"--voxel", "--min-count", "--resolution", "--height", "--max-depth", "--stride",
                             "--submap", "--upright", "--images", "--points", "--mesh", "--octree", "--objects"})
      if (command->count(flag) > 0) flags->given.emplace_back(flag);
    if (flags->quiet) set_log_sink({});
    run_export(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
