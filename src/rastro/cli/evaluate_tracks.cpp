// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/evaluate_tracks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/text.h"
#include "rastro/cli/open_ground_truth.h"
#include "rastro/cli/track_run_input.h"
#include "rastro/evaluate/clean_scores.h"
#include "rastro/evaluate/score_report.h"
#include "rastro/export/read_tracks.h"
#include "rastro/sensor/stamp_text.h"
#include "rastro/synthetic/occluder/occluder_masks.h"

namespace rastro::cli {
namespace {

constexpr const char* evaluate_tracks_footer =
    R"(Against exact ground truth (--ground-truth DATA, a recording of `rastro simulate`):
  anchor        surface point at the pixel of an id's last observation before it was lost; for a corner on an occluding edge
                the nearest surface of the 3x3 pixels around it
  lost          ids that end from one frame to the next and whose anchor is occluded in at least one frame before the id is
                re-identified or the window ends; counted apart: losses by leaving the image (lost_outside), of visible
                anchors (lost_visible) and where the ground truth has no surface (lost_unscored)
  reappeared    of these, those whose anchor is visible again within the window, --border px inside the image
  recalled      of these, those re-identified within the window at the right position; recall = recalled / reappeared
  reidentified  corners that were given the id of a lost feature, whatever the cause of the loss
  correct       the anchor is visible in this frame within --tolerance px of the corner, and the corner is on the same surface
                (or projects to within the tolerance of the anchor in the anchor's frame); wrong: all others; unscored: no
                surface there; precision = correct / (correct + wrong)
  id_switches   consecutive observations of an id whose surface points project farther than the tolerance from each other
On real recordings (--clean RUN2): RUN was made on a copy written by `rastro occlude`, RUN2 on the original recording. The
tracks of RUN2, as far as optical flow alone tracked them, are the ground truth; the occluder masks of the copy tell what was
occluded. A feature belongs to the clean track that coincides with it (1.5 px) when the occluder was last far from it; without
one it is unscored, and the share of these is reported. Make RUN2 dense: --mode klt --features 1500 --set min_distance_px=5.
Window, border and corner distance are those of the run unless given. A score without events is null (n/a).

Examples:
  rastro simulate hall --out hall && rastro track hall --out run && rastro evaluate tracks run --ground-truth hall
  rastro evaluate tracks run --ground-truth hall --frames 0:30 --per-frame --csv scores.csv
  rastro evaluate tracks run --ground-truth hall --json --require 'recall>=0.7' --require 'precision>=0.98'
  rastro occlude MH_01 --out MH_01_occluded --seed 1
  rastro track MH_01_occluded --out run
  rastro track MH_01 --out clean --mode klt --features 1500 --set min_distance_px=5
  rastro evaluate tracks run --clean clean)";

struct EvaluateTracksFlags {
  std::string run, ground_truth, clean, occluded, frames, csv;
  std::optional<int> window;
  std::optional<double> border_px;
  double tolerance_px = 3.0;
  std::vector<std::string> limits;
  bool json = false, per_frame = false, quiet = false;
};

/// The masks of an occluded copy as the scores ask for them: by frame of the run.
class MaskCover : public OccluderCover {
 public:
  MaskCover(const TrackTable& table, const std::string& data_folder) : table_(table), masks_(data_folder) {}
  bool covered(std::int64_t frame, const Eigen::Vector2d& pixel, double radius_px) const override {
    return masks_.covered(table_.frames[static_cast<std::size_t>(frame)].stamp, pixel, radius_px);
  }
  const GrayImage& first_mask() const { return masks_.mask(table_.frames.front().stamp); }

 private:
  const TrackTable& table_;
  OccluderMasks masks_;
};

/// Position of the first frame of the run with a number of at least `text`.
std::int64_t position_of(std::string_view text, std::int64_t if_empty, const TrackTable& table) {
  if (text.empty()) return if_empty;
  const auto number = parse_int64(text);
  if (!number || *number < 0)
    throw Error("'" + std::string(text) + "' is not a frame number", "--frames", "give A:B, frames A to B-1");
  const auto found = std::lower_bound(table.frames.begin(), table.frames.end(), *number,
                                      [](const TrackFrame& frame, std::int64_t value) { return frame.index < value; });
  return found - table.frames.begin();
}

void choose_frames(const std::string& frames, const TrackTable& table, TrackScoreOptions& options) {
  if (frames.empty()) return;
  const auto ends = split(frames, ':');
  if (ends.size() != 2)
    throw Error("'" + frames + "' is not a range of frames", "--frames", "give A:B, frames A to B-1");
  options.first_frame = position_of(ends[0], 0, table);
  options.end_frame = position_of(ends[1], static_cast<std::int64_t>(table.frames.size()), table);
}

TrackScoreOptions score_options(const EvaluateTracksFlags& flags, const TrackRunInput& input, const TrackTable& table) {
  TrackScoreOptions options;
  options.window = flags.window.value_or(input.options.window);
  options.border_px = flags.border_px.value_or(input.options.corner_border_px);
  options.tolerance_px = flags.tolerance_px;
  options.min_distance_px = input.options.min_distance_px;
  options.image_width = input.image_width;
  options.image_height = input.image_height;
  choose_frames(flags.frames, table, options);
  return options;
}

[[noreturn]] void refuse_ground_truth(const std::string& what, const std::string& ground_truth) {
  throw Error(what, ground_truth, "give the recording of the run");
}

void require_same_size(const TrackRunInput& input, int width, int height, const std::string& ground_truth) {
  if (input.image_width == 0 || width == 0 || (input.image_width == width && input.image_height == height)) return;
  refuse_ground_truth(fmt::format("the images of the run are {}x{}, those of this {}x{}", input.image_width,
                                  input.image_height, width, height),
                      ground_truth);
}

/// Error where frame numbers, timestamps or image size show that run and ground truth are of different recordings.
void require_same_recording(const EvaluateTracksFlags& flags, const TrackRunInput& input, const TrackTable& table,
                            const OpenedGroundTruth& opened) {
  constexpr TimeNs tolerance = 1'000'000;
  require_same_size(input, opened.image_width, opened.image_height, flags.ground_truth);
  for (const TrackFrame& frame : table.frames) {
    if (frame.index < 0 || frame.index >= opened.ground_truth->frame_count())
      refuse_ground_truth(fmt::format("the run has frame {}, the ground truth has {} frames", frame.index,
                                      opened.ground_truth->frame_count()),
                          flags.ground_truth);
    const TimeNs stamp = opened.stamps[static_cast<std::size_t>(frame.index)];
    if (std::abs(frame.stamp - stamp) > tolerance)
      refuse_ground_truth(
          fmt::format("is of another recording: frame {} has timestamp {} in the run and {} in the ground truth",
                      frame.index, seconds_text(frame.stamp), seconds_text(stamp)),
          flags.ground_truth);
  }
}

/// Generated recordings may share timestamps and camera.
void warn_of_drift(const TrackScores& scores, const std::string& ground_truth) {
  constexpr double most_share = 0.5;
  if (scores.drifted_share > most_share)
    log_warning(
        fmt::format("{}: {:.0f} % of the observations have drifted off their surface: is this the ground truth of the "
                    "recording of the run?",
                    ground_truth, 100.0 * scores.drifted_share));
}

TrackScores against_ground_truth(const EvaluateTracksFlags& flags, const TrackRunInput& input, const TrackTable& table,
                                 TrackScoreOptions options) {
  const OpenedGroundTruth opened = open_ground_truth(flags.ground_truth);
  require_same_recording(flags, input, table, opened);
  options.image_width = opened.image_width;
  options.image_height = opened.image_height;
  std::vector<std::int64_t> numbers;
  for (const TrackFrame& frame : table.frames) numbers.push_back(frame.index);
  const TrackScores scores = score_tracks(table, MappedGroundTruth(*opened.ground_truth, std::move(numbers)), options);
  warn_of_drift(scores, flags.ground_truth);
  return scores;
}

TrackScores against_clean(const EvaluateTracksFlags& flags, const TrackRunInput& input, const TrackTable& table,
                          TrackScoreOptions options) {
  const TrackTable clean = read_tracks(flags.clean);
  const TrackRunInput clean_input = read_run_input(flags.clean);
  require_same_size(input, clean_input.image_width, clean_input.image_height, flags.clean);
  const std::string data = flags.occluded.empty() ? input.data_path : flags.occluded;
  if (OccluderMasks::present(data)) {
    const MaskCover cover(table, data);
    options.image_width = cover.first_mask().width();
    options.image_height = cover.first_mask().height();
    return score_clean_tracks(table, clean, &cover, options);
  }
  if (!flags.occluded.empty())
    throw Error("has no occluder masks", flags.occluded, "give a folder written by `rastro occlude`");
  log_warning("no occluder masks found in '" + data +
              "': the cause of a loss is unknown; give --occluded DATA, the folder written by `rastro occlude`");
  return score_clean_tracks(table, clean, nullptr, options);
}

int missed_limits(const TrackScores& scores, const std::vector<ScoreLimit>& limits) {
  int code = done;
  for (const ScoreLimit& limit : limits) {
    if (keeps_limit(scores, limit)) continue;
    const auto value = score_named(scores, limit.name);
    fmt::print(stderr, "rastro: --require {}{}{} missed: it is {}\n", limit.name,
               limit.at_least ? ">=" : "<=", limit.value, value ? fmt::format("{:.4g}", *value) : "n/a");
    code = limit_missed;
  }
  return code;
}

int evaluate_tracks(const EvaluateTracksFlags& flags) {
  if (flags.ground_truth.empty() == flags.clean.empty())
    throw Error("needs one ground truth", "evaluate tracks", "give either --ground-truth DATA or --clean RUN2");
  std::vector<ScoreLimit> limits;
  for (const std::string& text : flags.limits) limits.push_back(parse_limit(text));
  const TrackTable table = read_tracks(flags.run);
  const TrackRunInput input = read_run_input(flags.run);
  const TrackScoreOptions options = score_options(flags, input, table);
  const TrackScores scores = flags.clean.empty() ? against_ground_truth(flags, input, table, options)
                                                 : against_clean(flags, input, table, options);
  if (!flags.csv.empty()) write_whole_file(flags.csv, scores_as_csv(scores));
  if (flags.json)
    fmt::print("{}", scores_as_json(scores, flags.per_frame));
  else if (!flags.quiet)
    fmt::print("{}", scores_as_text(scores, flags.per_frame));
  return missed_limits(scores, limits);
}

}  // namespace

void add_evaluate_tracks_command(CLI::App& evaluate, Context& context) {
  CLI::App* command =
      evaluate.add_subcommand("tracks", "Recall and precision of re-identification, id switches, track lengths");
  const auto flags = std::make_shared<EvaluateTracksFlags>();
  command->add_option("RUN", flags->run, "Run folder of `rastro track`, or its tracks.csv or tracks.yaml")
      ->type_name("")
      ->required();
  command->add_option("--ground-truth", flags->ground_truth, "Recording of `rastro simulate`")->type_name("DATA");
  command->add_option("--clean", flags->clean, "Run on the original of an occluded recording")->type_name("RUN2");
  command->add_option("--occluded", flags->occluded, "Recording with the occluder masks (default: that of RUN)")
      ->type_name("DATA");
  command->add_option("--frames", flags->frames, "Evaluate frames A to B-1 only (default: all)")->type_name("A:B");
  command
      ->add_option("--window", flags->window, "Frames for which a lost feature can be re-identified (default: of RUN)")
      ->type_name("N");
  command->add_option("--tolerance", flags->tolerance_px, "Maximum distance of matching positions in px (default: 3)")
      ->type_name("PX");
  command
      ->add_option("--border", flags->border_px,
                   "Ignore reappearances this close to the image edge, in px (default: of RUN)")
      ->type_name("PX");
  command
      ->add_option("--require", flags->limits,
                   "Limit, such as 'recall>=0.7' or 'wrong<=3'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false);
  command->add_option("--csv", flags->csv, "Write the scores per frame as CSV")->type_name("FILE");
  command->add_flag("--per-frame", flags->per_frame, "Print the scores per frame");
  command->add_flag("--json", flags->json, "Print the result as JSON");
  command->add_flag("--quiet", flags->quiet, "Print errors and warnings only");
  command->footer(evaluate_tracks_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    context.exit_code = evaluate_tracks(*flags);
  });
}

}  // namespace rastro::cli
