// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/map_path.h"
#include "rastro/cli/scale_run.h"
#include "rastro/cli/trajectory_files.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/landmarks/map_scale.h"

namespace rastro::cli {
namespace {

constexpr const char* footer =
    R"(One camera does not see how large the world is: its map has a unit of its own. This finds what the unit is in metres, and
writes it, with its sigma, into the map; of the folder of a run, trajectory.txt, trajectory_online.txt, covariance_online.txt,
keyframes.txt, map.png and result.json are brought to metres too. Give one of:
  --length         two landmarks (ids from 'rastro export RUN --to landmarks --out landmarks.csv') and the metres between them,
                   or two frames, f0,f120,METRES, and the metres between the camera's positions. Two or more give a sigma by
                   their residuals; one of landmarks the sigma of their positions; one of frames none
  --reference      a trajectory file or a recording with ground truth, on the clock of the recording
  --camera-height  of a camera carried level over flat ground that looks about where it goes, as on a car
Maps of two cameras or of depth are in metres already.

Examples:
  rastro scale run --length 17,230,1.84 --length 52,41,0.75
  rastro scale run --length f0,f120,14.2
  rastro scale run --reference kitti_00
  rastro scale run/map.rastro --camera-height 1.65)";

struct Flags {
  std::string map, reference;
  std::vector<std::string> lengths;
  double camera_height_m = 0.0;
  bool json = false, quiet = false;
};

[[noreturn]] void refuse_length(const std::string& text) {
  throw Error(in_quotes(text) + " is no length", "--length", "give A,B,METRES, such as 17,230,1.84 or f0,f120,14.2");
}

KnownLength parse_length(const std::string& text) {
  const auto parts = split(text, ',');
  if (parts.size() != 3) refuse_length(text);
  KnownLength length;
  const bool frames[2] = {parts[0].starts_with('f'), parts[1].starts_with('f')};
  if (frames[0] != frames[1]) refuse_length(text);
  length.between_frames = frames[0];
  const auto from = parse_int64(parts[0].substr(frames[0] ? 1 : 0)),
             to = parse_int64(parts[1].substr(frames[0] ? 1 : 0));
  const auto metres = parse_finite(parts[2]);
  if (!from || !to || *from < 0 || *to < 0 || !metres || !(*metres > 0.0)) refuse_length(text);
  length.from = *from, length.to = *to, length.metres = *metres;
  return length;
}

MapScaleFound find_scale(const Flags& flags, const Map& map) {
  const int ways =
      (flags.lengths.empty() ? 0 : 1) + (flags.reference.empty() ? 0 : 1) + (flags.camera_height_m > 0 ? 1 : 0);
  if (ways != 1)
    throw Error(ways == 0 ? "nothing says how long anything is" : "more than one thing says how long everything is",
                flags.map, "give one of --length, --reference and --camera-height");
  if (!flags.lengths.empty()) {
    std::vector<KnownLength> lengths;
    for (const std::string& text : flags.lengths) lengths.push_back(parse_length(text));
    return scale_from_lengths(map, lengths, "--length");
  }
  if (flags.camera_height_m > 0.0) return scale_from_camera_height(map, flags.camera_height_m, "--camera-height");
  const ReferenceTrajectory reference = read_reference(flags.reference, {});
  if (!reference.input.has_stamps)
    throw Error("has no stamps", flags.reference, "put its times.txt beside it, or give it as TUM text");
  Trajectory of_camera = reference.input.poses;
  if (const auto& mount = reference.body_from_camera_of_estimates)
    for (StampedPose& pose : of_camera) pose.world_from_body = pose.world_from_body * *mount;
  return scale_from_reference(map, of_camera, "--reference");
}

std::shared_ptr<const Map> scalable_map(const std::string& file) {
  auto map = load_map(file);
  const auto& cameras = map->cameras;
  const bool mono = std::all_of(cameras.begin(), cameras.end(),
                                [](const MapCamera& camera) { return camera.kind == CameraKind::mono; });
  if (cameras.empty() || !mono)
    throw Error("is in metres already, from " + one_line(scale_of(*map).origin), file,
                "only maps of one camera need a scale");
  return map;
}

void scale(const Flags& flags, bool height_given) {
  constexpr double highest_m = 1000.0;
  if (height_given && !(flags.camera_height_m > 0.0 && flags.camera_height_m <= highest_m))
    throw Error(fmt::format("{:g} m is no height of a camera", flags.camera_height_m), "--camera-height",
                "give metres above the ground, such as 1.65");
  const std::string file = map_file_of(flags.map).string();
  const auto map = scalable_map(file);
  const MapScaleFound found = find_scale(flags, *map);
  const Map in_metres = scaled(*map, found);
  if (file == flags.map)
    save_map(in_metres, file);
  else
    scale_run_folder(flags.map, in_metres, found);
  if (flags.json)
    fmt::print("{{\n  \"metres_per_unit\": {:.9g},\n  \"relative_sigma\": {:.3g},\n  \"measurements\": {}\n}}\n",
               found.metres_per_unit, found.relative_sigma, found.measurements);
  else if (!flags.quiet)
    fmt::print("{}: 1 unit of before is {:.6g} m, {}, from {} ({} measurements)\n", flags.map, found.metres_per_unit,
               found.relative_sigma > 0.0 ? fmt::format("sigma {:.2g} %", 100.0 * found.relative_sigma)
                                          : std::string("sigma not known"),
               found.from, found.measurements);
}

}  // namespace

void add_scale_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("scale", "Bring the map of one camera to metres");
  const auto flags = std::make_shared<Flags>();
  command->add_option("RUN", flags->map, "Folder of a run, or a map file")->required()->type_name("RUN|MAP");
  command->add_option("--length", flags->lengths, "A known length between two landmarks or two frames, may be repeated")
      ->type_name("A,B,METRES")
      ->allow_extra_args(false);
  command
      ->add_option("--reference", flags->reference, "A trajectory in metres: a file, or a recording with ground truth")
      ->type_name("FILE");
  command->add_option("--camera-height", flags->camera_height_m, "Of the camera above flat ground")->type_name("M");
  command->add_flag("--json", flags->json, "Print JSON");
  command->add_flag("--quiet", flags->quiet, "Print nothing but what goes wrong");
  command->footer(footer);
  command->callback([command, flags, &context] {
    scale(*flags, command->count("--camera-height") > 0);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
