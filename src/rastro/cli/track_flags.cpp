// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/track_flags.h"

#include <fmt/format.h>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/cli/live_flags.h"

namespace rastro::cli {
namespace {

constexpr const char* track_footer = R"(Output files, in --out:
  tracks.yaml tracks.csv tracks.jsonl  per frame and feature: id, pixel, undistorted ray, age, state, last observation
  table.md       features tracked and re-identified per frame, as Table I of the paper
  stats.csv      counts and times per frame
  events.jsonl   skipped frames, frames with few features or abrupt motion
  options.yaml   options in use
  about.json     version, machine, input, command line
  result.json    frames, coverage (% of the requested frames), times, memory, hash of the result
Frames are numbered as in the recording. A run that is stopped (Ctrl-C) or killed keeps all frames written so far;
Ctrl-C ends with exit code 0 and "interrupted": true in result.json.

Examples:
  rastro track hall --out run --images
  rastro track MH_01_easy --out run --match-image 1:29 --video run.avi
  rastro track MH_01_easy --out paper --preset paper --frames 0:31 --table 21:31    Table I of the paper
  rastro track walk.mp4 --fov 70 --out run --set min_distance_px=20 --features 300
  rastro track hall --out run --view                  in a browser, while it runs
  rastro track kitti/00 --frames 0:500 --mask hood.png --out run --require 'coverage>=99'
  rastro options --yaml > mine.yaml && rastro track hall --out run --options mine.yaml)";

void add_setting_flags(CLI::App& command, TrackFlags& flags) {
  const char* group = "Tracker";
  command.add_option("--mode", flags.mode, "Re-identification: klt (none), vote, dual or priority (default: priority)")
      ->type_name("MODE")
      ->group(group);
  command.add_option("--features", flags.features, "Features per frame (default: 150)")->type_name("N")->group(group);
  command.add_option("--window", flags.window, "Frames for which a lost feature can be re-identified (default: 30)")
      ->type_name("N")
      ->group(group);
  command
      .add_option("--validation", flags.validation,
                  "Geometric verification: homography, epipolar or local (default: homography)")
      ->type_name("MODE")
      ->group(group);
  add_preset_flag(command, flags, group, "the front-end paper's own steps");
  add_settings_flags(command, flags, group, "rastro options");
  command.add_option("--mask", flags.mask, "Mask image, or folder of one per frame: no features where it is black")
      ->type_name("FILE|FOLDER")
      ->group(group);
}

void add_output_flags(CLI::App& command, TrackFlags& flags) {
  const char* group = "Output";
  add_folder_flags(command, flags);
  command.add_option("--formats", flags.formats, "Track files to write, of yaml,csv,jsonl (default: all)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->group(group);
  command.add_flag("--images", flags.images, "Draw every frame: features in red, ids in green")->group(group);
  command.add_option("--match-image", flags.match_image, "Draw the matches between frames A and B")
      ->type_name("A:B")
      ->group(group);
  command.add_option("--table", flags.table, "Frames A to B-1 of table.md and its mean (default: all)")
      ->type_name("A:B")
      ->group(group);
  command.add_option("--video", flags.video, "Write the drawn frames as a video, .avi or .mp4")
      ->type_name("FILE")
      ->group(group);
  command
      .add_option("--require", flags.limits,
                  "Limit on a value of result.json, such as 'coverage>=95'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false)
      ->group(group);
}

/// "A:B" with A below B; nullopt for an empty text.
std::optional<std::pair<std::int64_t, std::int64_t>> frame_pair(const std::string& text, const char* flag,
                                                                const char* advice) {
  if (text.empty()) return std::nullopt;
  const auto ends = split(text, ':');
  if (ends.size() == 2) {
    const auto first = parse_int64(ends[0]);
    const auto second = parse_int64(ends[1]);
    if (first && second && *first >= 0 && *first < *second) return std::pair(*first, *second);
  }
  throw Error(fmt::format("'{}' is not a pair of frames", one_line(text)), flag, advice);
}

}  // namespace

void add_track_flags(CLI::App& command, TrackFlags& flags) {
  add_output_flags(command, flags);
  add_setting_flags(command, flags);
  add_live_flags(command, flags.live);
  add_record_flag(command, flags.live);
  add_view_flags(command, flags);
  add_data_flags(command, flags.data);
  command.footer(track_footer);
}

void apply_preset(const TrackFlags& flags, TrackOptions& options) {
  if (is_preset(flags.preset, "the tracker", track_presets())) set_paper_preset(options);
}

void apply_settings(const TrackFlags& flags, OptionTable& table) {
  apply_given_settings(flags, table);
  const std::pair<const char*, const std::string*> direct[] = {{"mode", &flags.mode},
                                                               {"features", &flags.features},
                                                               {"window", &flags.window},
                                                               {"validation", &flags.validation}};
  for (const auto& [name, value] : direct) {
    if (!value->empty()) table.set(name, *value, fmt::format("--{}", name));
  }
  apply_given_seed(flags, table);
}

std::optional<std::pair<std::int64_t, std::int64_t>> match_frames(const TrackFlags& flags) {
  return frame_pair(flags.match_image, "--match-image", "give two frame numbers, the earlier one first, such as 1:29");
}

std::optional<std::pair<std::int64_t, std::int64_t>> table_frames(const TrackFlags& flags) {
  return frame_pair(flags.table, "--table", "give A:B with A below B, such as 21:31 for frames 21 to 30");
}

}  // namespace rastro::cli
