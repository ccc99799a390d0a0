// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/command.h"
#include "rastro/cli/map_path.h"
#include "rastro/cli/recording_of_run.h"
#include "rastro/cli/scale_run.h"
#include "rastro/cli/trajectory_files.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/landmarks/map_scale.h"

namespace rastro::cli {
namespace {

constexpr const char* scale_footer =
    R"(A map of one camera is known up to scale. This estimates the scale with its sigma and makes the map metric; of a run
(its folder, or the map.rastro in it) also trajectory.txt, trajectory_online.txt, covariance_online.txt, keyframes.txt,
map.png and result.json. The first keyframe stays where it is, so that --initial-pose holds. Give one of:
  --length         distance in meters between two landmarks (ids: 'rastro export RUN --to landmarks --out landmarks.csv')
                   or, as f0,f120,METERS, between the camera positions of two frames (of the first session). The sigma is
                   from the residuals of two or more lengths, from the landmarks' position sigmas of one, and unknown
                   with one pair of frames
  --reference      trajectory file or recording with ground truth, with the timestamps of the recording. Of a map whose
                   sessions overlap in time: the recording of one of them, or a file in its folder
  --camera-height  height of a level camera that looks along its motion over flat ground, as on a car
Maps from stereo or depth are metric already.

Examples:
  rastro scale run --length 17,230,1.84 --length 52,41,0.75
  rastro scale run --length f0,f120,14.2
  rastro scale run --reference kitti_00
  rastro scale run/map.rastro --camera-height 1.65)";

struct ScaleFlags {
  std::string map, reference;
  std::vector<std::string> lengths;
  double camera_height_m = 0.0;
  bool json = false, quiet = false;
};

[[noreturn]] void refuse_length(const std::string& text) {
  throw Error(in_quotes(text) + " is not a length", "--length", "give A,B,METERS, such as 17,230,1.84 or f0,f120,14.2");
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
  const auto meters = parse_finite(parts[2]);
  if (!from || !to || *from < 0 || *to < 0 || !meters || !(*meters > 0.0)) refuse_length(text);
  length.from = *from, length.to = *to, length.meters = *meters;
  return length;
}

MapScaleFound find_scale(const ScaleFlags& flags, const Map& map) {
  const int given =
      (flags.lengths.empty() ? 0 : 1) + (flags.reference.empty() ? 0 : 1) + (flags.camera_height_m > 0 ? 1 : 0);
  if (given != 1)
    throw Error(given == 0 ? "no source of scale is given" : "more than one source of scale is given", flags.map,
                "give one of --length, --reference and --camera-height");
  if (!flags.lengths.empty()) {
    std::vector<KnownLength> lengths;
    for (const std::string& text : flags.lengths) lengths.push_back(parse_length(text));
    return scale_from_lengths(map, lengths, "--length");
  }
  if (flags.camera_height_m > 0.0) return scale_from_camera_height(map, flags.camera_height_m, "--camera-height");
  const ReferenceTrajectory reference = read_reference(flags.reference, {});
  if (!reference.input.has_stamps)
    throw Error("has no timestamps", flags.reference, "put its times.txt beside it, or convert it to TUM format");
  return scale_from_reference(map, poses_of_camera(reference), "--reference",
                              session_of_reference(map, map_file_of(flags.map), flags.reference));
}

std::shared_ptr<const Map> scalable_map(const std::string& file) {
  auto map = load_map(file);
  const auto& cameras = map->cameras;
  const bool mono = std::all_of(cameras.begin(), cameras.end(),
                                [](const MapCamera& camera) { return camera.kind == CameraKind::mono; });
  if (cameras.empty() || !mono)
    throw Error("is metric already, from " + one_line(scale_of(*map).origin), file,
                "only maps of one camera need a scale");
  return map;
}

/// Of a map file, too, the run that it is of: its trajectory would stay in another unit.
std::filesystem::path run_folder_of(const std::string& map, const std::string& file) {
  std::error_code code;
  if (file != map) return map;
  const auto folder = std::filesystem::path(file).parent_path();
  const bool is_of_run =
      std::filesystem::path(file).filename() == "map.rastro" && std::filesystem::exists(folder / "result.json", code);
  return is_of_run ? (folder.empty() ? std::filesystem::path(".") : folder) : std::filesystem::path();
}

void warn_of_contradiction(const std::string& file, const MapScale& before, const MapScaleFound& found) {
  constexpr double least = 0.05, sure = 4.0, if_unknown = 0.025;
  const auto sigma = [](double given) { return given > 0.0 ? given : if_unknown; };
  const double difference = std::abs(std::log(found.meters_per_unit));
  if (!before.metric ||
      difference < std::max(least, sure * std::hypot(sigma(before.relative_sigma), sigma(found.relative_sigma))))
    return;
  log_warning(
      fmt::format("{} was in meters already, by {}: by {} its lengths are {:.3g} times as long, which is kept "
                  "now; one of them is wrong",
                  file, one_line(before.origin), one_line(found.from), found.meters_per_unit));
}

void warn_of_misfit(const MapScaleFound& found, const std::string& reference) {
  constexpr double most_off = 0.1, some_turn_deg = 2.0, most_turn_deg = 6.0;
  const bool is_off = found.position_misfit > most_off && found.turn_misfit_deg > some_turn_deg;
  if (!is_off && found.turn_misfit_deg < most_turn_deg) return;
  log_warning(
      fmt::format("{} fits the map badly: aligned, the positions are {:.0f} % of their spread off, and what the camera "
                  "turned differs by {:.1f} deg; is it of this recording?",
                  one_line(reference), 100.0 * found.position_misfit, found.turn_misfit_deg));
}

/// A submap that nothing connects has a unit of its own.
void warn_of_other_submaps(const Map& map) {
  const auto apart = std::count_if(map.keyframes.begin(), map.keyframes.end(),
                                   [](const Keyframe& keyframe) { return keyframe.submap != 0; });
  if (apart == 0) return;
  log_warning(
      fmt::format("{} of {} keyframes are in submaps that nothing connects to the first: their scale is another one, "
                  "which stays unknown",
                  apart, map.keyframes.size()));
}

void scale(const ScaleFlags& flags, bool height_given) {
  constexpr double highest_m = 1000.0;
  if (height_given && !(flags.camera_height_m > 0.0 && flags.camera_height_m <= highest_m))
    throw Error(fmt::format("{:g} m is not a camera height", flags.camera_height_m), "--camera-height",
                "give meters above the ground, up to 1000, such as 1.65");
  const std::string file = map_file_of(flags.map).string();
  const auto map = scalable_map(file);
  const MapScaleFound found = find_scale(flags, *map);
  const Map in_meters = scaled(*map, found);
  warn_of_contradiction(file, scale_of(*map), found);
  warn_of_misfit(found, flags.reference);
  warn_of_other_submaps(*map);
  const std::filesystem::path folder = run_folder_of(flags.map, file);
  if (folder.empty())
    save_map(in_meters, file);
  else
    scale_run_folder(folder, in_meters, found);
  if (flags.json)
    fmt::print("{{\n  \"meters_per_unit\": {:.9g},\n  \"relative_sigma\": {:.3g},\n  \"measurements\": {}\n}}\n",
               found.meters_per_unit, found.relative_sigma, found.measurements);
  else if (!flags.quiet)
    fmt::print("{}: scale {:.6g} m per map unit, {}, from {} ({} measurements)\n", flags.map, found.meters_per_unit,
               found.relative_sigma > 0.0 ? fmt::format("sigma {:.2g} %", 100.0 * found.relative_sigma)
                                          : std::string("sigma unknown"),
               found.from, found.measurements);
}

}  // namespace

void add_scale_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("scale", "Makes the map of one camera metric");
  const auto flags = std::make_shared<ScaleFlags>();
  command->add_option("RUN", flags->map, "Run folder or map file")->required()->type_name("");
  command->add_option("--length", flags->lengths, "Known distance between two landmarks or two frames; may be repeated")
      ->type_name("A,B,METERS")
      ->allow_extra_args(false);
  command->add_option("--reference", flags->reference, "Metric trajectory: a file, or a recording with ground truth")
      ->type_name("FILE");
  command->add_option("--camera-height", flags->camera_height_m, "Height of the camera above flat ground, in meters")
      ->type_name("M");
  command->add_flag("--json", flags->json, "Print the result as JSON");
  command->add_flag("--quiet", flags->quiet, "Print errors and warnings only");
  command->footer(scale_footer);
  command->callback([command, flags, &context] {
    scale(*flags, command->count("--camera-height") > 0);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
