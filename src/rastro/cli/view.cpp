// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/cloud_scene.h"
#include "rastro/cli/command.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/cli/recording_scene.h"
#include "rastro/cli/scene_input.h"
#include "rastro/cli/scene_lengths.h"
#include "rastro/cli/server_flags.h"
#include "rastro/cli/track_scene.h"
#include "rastro/map/file/map_file.h"
#include "rastro/viewer/view_server.h"

namespace rastro::cli {
namespace {

constexpr const char* view_footer =
    R"(RUN is a run folder, a map file (map.rastro), a trajectory file, a cloud (PLY) or a recording; several are laid over
each other. Shown are trajectory (final and as first estimated, ground truth where the recording has one; by state, error,
time or uncertainty), keyframes, covisibility and essential graph, constraints and loop closures, landmarks, cloud,
semi-dense points, laser scans, occupancy grid and covariances, in layers that can be switched. Of a recording: its images,
depth of the current frame as cloud, laser scans, and the ground truth or wheel odometry as trajectory. Of a run of
'rastro track': each image with its features by state, their ids and trails. Layers of more than a million points come in
tiles as the view needs them, so that maps of many millions can be looked at.

Lengths can be measured in the page between points, edges and faces; of a map with depth images the last two are measured
as 'rastro measure' does. Named lengths are shown of --objects FILE, and of lengths.json in a run folder
('rastro measure run --objects FILE --json > run/lengths.json').

The page needs nothing but this program: no network, no installation. It is served on this machine only, until Ctrl-C.
--listen ADDRESS serves it to other machines too, which need the token in the address that is printed. The connection
is not encrypted: use it in networks that you trust, or an SSH tunnel ('ssh -L 8420:localhost:8420 HOST').
'rastro export RUN --to html' writes the same as one file.

Examples:
  rastro view run                               open the address that it prints
  rastro view monday tuesday                    two runs in one picture
  rastro view run/map.rastro --port 9000
  rastro view cloud.ply                         points of any program
  rastro view rgbd_dataset_freiburg1_room       a recording, frame by frame
  rastro view run --listen 0.0.0.0              from other machines, with a generated token)";

struct ViewFlags {
  std::vector<std::string> inputs;
  SceneFlags scene;
  ServerFlags server;
  std::string submap = "0";
  int threads = 0;
  bool json = false, quiet = false;
};

/// -1 is all.
int submap_in(const ViewFlags& flags) {
  if (flags.submap == "all") return -1;
  const auto submap = parse_int64(flags.submap);
  if (submap && *submap >= 0 && *submap < 1'000'000) return static_cast<int>(*submap);
  throw Error(in_quotes(flags.submap) + " is not a submap", "--submap", "give a number, or all");
}

/// Else it is a recording. A file of poses has the extension of one.
bool is_run_or_map(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path folder = path;
  if (fs::is_directory(folder, ignored))
    return fs::exists(folder / "map.rastro", ignored) || fs::exists(folder / "trajectory.txt", ignored);
  if (!fs::is_regular_file(folder, ignored)) return false;
  const std::string extension = folder.extension().string();
  return is_map_file(path) || extension == ".txt" || extension == ".csv" || extension == ".tum";
}

bool is_cloud(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored) && std::filesystem::path(path).extension() == ".ply";
}

TileProgress tiling_shown_in(ProgressBar& bar) {
  return [&bar](std::size_t done, std::size_t all) { bar.show_steps("points in tiles", done, all); };
}

NamedScene shown(const ExportInput& input, const ViewFlags& flags, const ViewSceneOptions& options, TaskPool& pool,
                 ProgressBar& bar) {
  const auto progress = [&](std::size_t done, std::size_t all) { bar.show_steps("keyframes", done, all); };
  NamedScene scene = served_scene_of(input, options, pool, progress, tiling_shown_in(bar), flags.scene.objects);
  scene.measure = measuring_in(input, flags.threads);
  return scene;
}

std::vector<NamedScene> read_scenes(const ViewFlags& flags) {
  constexpr std::size_t default_points = 50'000'000;  // as many as there are
  if (flags.threads < 0 || flags.threads > 1024)
    throw Error(fmt::format("{} is out of range", flags.threads), "--threads", "give 0 to 1024");
  const ViewSceneOptions options = scene_options(flags.scene, submap_in(flags), default_points);
  TaskPool pool(flags.threads);
  ProgressBar bar(!flags.quiet);
  std::vector<NamedScene> scenes;
  for (const std::string& input : flags.inputs) {
    if (is_run_or_map(input)) {
      scenes.push_back(shown(read_export_input(input), flags, options, pool, bar));
    } else if (is_track_run(input)) {
      scenes.push_back(track_scene(input));
    } else if (is_cloud(input)) {
      scenes.push_back(cloud_scene(input, options.max_points, tiling_shown_in(bar)));
    } else {
      scenes.push_back(recording_scene(input));
    }
  }
  bar.clear();
  return scenes;
}

void say_where(const ViewFlags& flags, const ViewServer& server) {
  if (flags.json) {
    const nlohmann::ordered_json json{{"url", server.url()}, {"port", server.port()}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{}\n", server.url());
  }
  std::fflush(stdout);  // it may be a pipe, and the program goes on
  if (!flags.quiet) fmt::print(stderr, "Open this address in a browser; stop with Ctrl-C.\n");
}

void run_view(const ViewFlags& flags) {
  const ViewServerOptions options = server_options(flags.server);
  std::vector<NamedScene> scenes = read_scenes(flags);
  catch_interrupts();
  ViewServer server(options, std::move(scenes));
  say_where(flags, server);
  wait_for_interrupt();
  server.stop();
}

}  // namespace

void add_view_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("view", "Shows runs, maps and recordings in a browser");
  const auto flags = std::make_shared<ViewFlags>();
  command->add_option("RUN", flags->inputs, "Run folders, map files, clouds or recordings")->required()->type_name("");
  add_server_flags(*command, flags->server, "");
  command->add_option("--points", flags->scene.points, "Maximum number of points of each layer (default: 50000000)")
      ->type_name("N");
  command->add_flag("--mesh", flags->scene.mesh, "Surfaces as triangles, too (rgbd)");
  command->add_flag("--octree", flags->scene.octree, "Occupied space as cubes, too (rgbd)");
  command->add_option("--objects", flags->scene.objects, "Lengths to measure and show, as of 'rastro measure'")
      ->type_name("FILE");
  command->add_option("--submap", flags->submap, "Submap (default: 0, the first)")->type_name("N|all");
  command->add_option("--threads", flags->threads, "Number of threads (default: all cores)")->type_name("N");
  command->add_flag("--json", flags->json, "Print the address as JSON");
  command->add_flag("--quiet", flags->quiet, "Print the address, errors and warnings only");
  command->footer(view_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    run_view(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
