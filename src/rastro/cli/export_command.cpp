// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/export_formats.h"
#include "rastro/cli/progress_bar.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* footer =
    R"(RUN is the folder of a run, MAP a map file (map.rastro); poses can also be taken from a trajectory file.
  ply      points; binary. With images: colored surfaces with normals, count (measurements) and sigma (m, along the
           normal). Else landmarks (gray; count: observations, sigma: along the view), semi-dense depth and scans
  pcd      the same as the Point Cloud Library reads it
  g2o      pose graph of the keyframes with information matrices; with landmarks its essential graph
  colmap   folder with cameras.txt, images.txt, points3D.txt and, of a map with images, images/
  pgm      FILE.pgm and FILE.yaml as ROS's map_server reads them: the occupancy grid of scans, or what stands between
           two heights
  tum, kitti, euroc   poses of all frames; kitti also writes FILE_times.txt
Of a map with images (--method rgbd):
  mesh     surfaces as triangles with colors; PLY
  octomap  occupied and free space as an OctoMap: FILE.ot with probabilities, FILE.bt occupied or free only
Of a map with landmarks (--method orb):
  landmarks  CSV: id, position, sigma, observations, and the frame and pixel that show it first
  svg, png   keyframes, landmarks, covisibility and essential graph from above
  colmap-binary   as colmap, .bin; images are named by frame, such as 000123.png
Lengths are in metres, in the world of the map: for a depth camera its first view, x right, y down, z ahead. With
--upright clouds, meshes and octrees stand on the floor: z up, the origin below the first camera, which looks along
x. A slice of images always does. The floor is the lowest large level plane seen; where there is none, up is the
cameras' mean up.

Examples:
  rastro export run --to ply --out room.ply
  rastro export run/map.rastro --to octomap --out room.bt --resolution 0.1 --upright
  rastro export run --to pgm --out floor.yaml --height 0.1:1.5
  rastro export run --to colmap --out colmap)";

struct Flags {
  ExportSettings settings;
  std::string input, height, submap = "0";
  std::optional<int> stride;
  bool json = false, quiet = false;
  int threads = 0;
};

struct Format {
  const char* name;
  ExportFacts (*write)(const ExportJob&);
};

constexpr Format formats[] = {{"ply", export_cloud},
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
                              {"svg", export_picture},
                              {"png", export_picture}};

const Format& format_named(const std::string& name) {
  std::vector<std::string> names;
  for (const Format& format : formats) {
    if (name == format.name) return format;
    names.emplace_back(format.name);
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
  flags.settings.lowest_m = lowest, flags.settings.highest_m = highest;
}

void settle(Flags& flags) {
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
    throw Error(in_quotes(flags.submap) + " is no submap", "--submap", "give its number, or all");
  settings.cloud.submap = settings.octree.submap = flags.submap == "all" ? -1 : static_cast<int>(*submap);
  checked(flags.threads, 0, 1024, "--threads", "");
  set_height(flags);
}

void refuse_input(const Flags& flags) {
  std::error_code ignored;
  for (const fs::path& file : {fs::path(flags.input), fs::path(flags.input) / "map.rastro"})
    if (fs::equivalent(file, flags.settings.out, ignored))
      throw Error("would overwrite what is exported", flags.settings.out, "give another --out");
}

void report(const Flags& flags, const ExportFacts& facts) {
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

void run_export(Flags& flags) {
  const Format& format = format_named(flags.settings.to);
  settle(flags);
  refuse_input(flags);
  const ExportInput input = read_export_input(flags.input);
  TaskPool pool(flags.threads);
  ProgressBar bar(!flags.quiet);
  const ExportFacts facts = format.write({flags.settings, input, pool, [&](std::size_t done, std::size_t all) {
                                            bar.show_steps("keyframes", done, all);
                                          }});
  bar.clear();
  report(flags, facts);
}

}  // namespace

void add_export_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("export", "Write a map or its poses for other programs");
  const auto flags = std::make_shared<Flags>();
  command->add_option("RUN", flags->input, "Folder of a run, or a map file")->required()->type_name("RUN|MAP");
  command
      ->add_option("--to", flags->settings.to,
                   "ply, pcd, mesh, octomap, pgm, g2o, colmap, colmap-binary, landmarks, svg, png, tum, kitti, euroc")
      ->required()
      ->type_name("FORMAT");
  command->add_option("--out", flags->settings.out, "File to write; for colmap a folder")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--voxel", flags->settings.voxel_m,
                   "Side of the voxels of ply and pcd (default: 0.01) and mesh (default: 0.02)")
      ->type_name("M");
  command
      ->add_option("--min-count", flags->settings.cloud.min_count,
                   "ply, pcd: leave out points of fewer measurements (default: 3)")
      ->type_name("N");
  command
      ->add_option("--resolution", flags->settings.octree.resolution_m,
                   "octomap, pgm: side of the cubes (default: 0.05)")
      ->type_name("M");
  command
      ->add_option("--height", flags->height, "pgm: what stands between A and B m above the floor (default: 0.1:1.8)")
      ->type_name("A:B");
  command
      ->add_option("--max-depth", flags->settings.max_depth_m,
                   "Leave out what was farther from the camera (default: 5)")
      ->type_name("M");
  command
      ->add_option("--stride", flags->stride,
                   "Every so many-th pixel each way (default: 2; 4 for octomap and pgm; mesh takes all)")
      ->type_name("N");
  command->add_option("--submap", flags->submap, "Number of the submap, or all (default: 0, the first)")
      ->type_name("N|all");
  command->add_flag("--upright", flags->settings.upright, "ply, pcd, mesh, octomap: stand the map on its floor, z up");
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
