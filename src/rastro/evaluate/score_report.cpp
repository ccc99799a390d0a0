// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/score_report.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }
std::string ratio_text(const std::optional<double>& value) { return value ? fmt::format("{:.3f}", *value) : "n/a"; }
std::string pixel_text(const std::optional<double>& value) { return value ? fmt::format("{:.2f} px", *value) : "n/a"; }

struct Column {
  const char* name;
  int FrameScores::*count;
};
constexpr std::array<Column, 13> columns = {{{"features", &FrameScores::features},
                                             {"tracked", &FrameScores::tracked},
                                             {"new", &FrameScores::fresh},
                                             {"reidentified", &FrameScores::reidentified},
                                             {"correct", &FrameScores::correct},
                                             {"wrong", &FrameScores::wrong},
                                             {"unscored", &FrameScores::unscored},
                                             {"lost", &FrameScores::lost},
                                             {"lost_outside", &FrameScores::lost_outside},
                                             {"lost_visible", &FrameScores::lost_visible},
                                             {"lost_unscored", &FrameScores::lost_unscored},
                                             {"reappeared", &FrameScores::reappeared},
                                             {"recalled", &FrameScores::recalled}}};

/// All scalar figures of a run, in the order they are written.
Json totals(const TrackScores& s) {
  Json json;
  json["recall"] = number_or_null(s.recall);
  json["precision"] = number_or_null(s.precision);
  json["lost"] = s.lost;
  json["reappeared"] = s.reappeared;
  json["recalled"] = s.recalled;
  json["reidentified"] = s.reidentified;
  json["correct"] = s.correct;
  json["wrong"] = s.wrong;
  json["unscored"] = s.unscored;
  json["unscored_on_occluder"] = s.unscored_on_occluder;
  json["unscored_share"] = s.reidentified > 0 ? Json(static_cast<double>(s.unscored) / s.reidentified) : Json(nullptr);
  json["wrong_but_earlier_place"] = s.wrong_but_earlier_position;
  json["lost_outside"] = s.lost_outside;
  json["lost_visible"] = s.lost_visible;
  json["lost_unscored"] = s.lost_unscored;
  json["id_switches"] = s.id_switches;
  json["duplicate_ids"] = s.duplicate_ids;
  json["drift_median_px"] = number_or_null(s.drift_median_px);
  json["drift_p95_px"] = number_or_null(s.drift_p95_px);
  json["drifted_share"] = number_or_null(s.drift_median_px ? std::optional(s.drifted_share) : std::nullopt);
  json["ids"] = s.ids;
  json["mean_track_length"] = number_or_null(s.mean_track_length);
  json["median_track_length"] = number_or_null(s.median_track_length);
  json["frame_count"] = s.frame_count;
  return json;
}

std::string bin_name(std::size_t bin) {
  const std::vector<int>& bins = length_bins();
  if (bin + 1 == bins.size()) return fmt::format("{}+", bins[bin]);
  if (bins[bin + 1] == bins[bin] + 1) return fmt::format("{}", bins[bin]);
  return fmt::format("{}-{}", bins[bin], bins[bin + 1] - 1);
}

Json frames_as_json(const TrackScores& scores) {
  Json frames = Json::array();
  for (const FrameScores& row : scores.frames) {
    Json json;
    json["frame"] = row.index;
    for (const Column& column : columns) json[column.name] = row.*column.count;
    frames.push_back(json);
  }
  return frames;
}

std::string reasons_as_text(const TrackScores& s) {
  std::string text;
  const MissReasons& m = s.misses;
  if (s.reappeared > s.recalled)
    text += fmt::format(
        "missed: {} = {} re-identified at a wrong position + {} detected but not re-identified + {} with another "
        "feature within "
        "the "
        "minimum distance + {} while no corner was detected at all + {} never detected\n",
        s.reappeared - s.recalled, m.wrong_position, m.not_reidentified, m.blocked, m.budget_full, m.never_detected);
  const WrongReasons& w = s.wrongs;
  if (s.wrong > 0)
    text += fmt::format(
        "wrong: {} = {} at another position + {} whose point is occluded + {} whose point is outside + {} on a surface "
        "in "
        "front "
        "+ {} of an unknown id\n       {} of them at an earlier position of the id (it had slipped off its point when "
        "it was "
        "lost)\n",
        s.wrong, w.other_position, w.anchor_occluded, w.anchor_outside, w.on_occluder, w.unknown_id,
        s.wrong_but_earlier_position);
  return text;
}

std::string lengths_as_text(const TrackScores& s) {
  if (!s.mean_track_length) return "tracks: none\n";
  std::string text = fmt::format("tracks: {} ids, mean {:.1f} observations, median {:.1f}\n       ", s.ids,
                                 *s.mean_track_length, *s.median_track_length);
  for (std::size_t bin = 0; bin < s.length_histogram.size(); ++bin)
    text += fmt::format(" {}: {}{}", bin_name(bin), s.length_histogram[bin],
                        bin + 1 < s.length_histogram.size() ? "," : "\n");
  return text;
}

std::string frames_as_text(const TrackScores& scores) {
  std::string text = fmt::format("{:>6}", "frame");
  for (const Column& column : columns) text += fmt::format(" {:>13}", column.name);
  text += "\n";
  for (const FrameScores& row : scores.frames) {
    text += fmt::format("{:>6}", row.index);
    for (const Column& column : columns) text += fmt::format(" {:>13}", row.*column.count);
    text += "\n";
  }
  return text;
}

}  // namespace

std::string scores_as_json(const TrackScores& s, bool per_frame) {
  Json json;
  json["truth"] = s.ground_truth;
  json.update(totals(s));
  json["misses"] = {{"wrong_place", s.misses.wrong_position},
                    {"not_recognized", s.misses.not_reidentified},
                    {"blocked", s.misses.blocked},
                    {"budget_full", s.misses.budget_full},
                    {"never_detected", s.misses.never_detected}};
  json["wrongs"] = {{"other_place", s.wrongs.other_position},
                    {"anchor_hidden", s.wrongs.anchor_occluded},
                    {"anchor_outside", s.wrongs.anchor_outside},
                    {"on_occluder", s.wrongs.on_occluder},
                    {"unknown_id", s.wrongs.unknown_id}};
  for (std::size_t bin = 0; bin < s.length_histogram.size(); ++bin)
    json["length_histogram"][bin_name(bin)] = s.length_histogram[bin];
  if (per_frame) json["frames"] = frames_as_json(s);
  return json.dump(2) + "\n";
}

std::string scores_as_text(const TrackScores& s, bool per_frame) {
  std::string text = per_frame ? frames_as_text(s) + "\n" : "";
  text += fmt::format("recall {}: {} of {} features that were lost to occlusion and reappeared were re-identified\n",
                      ratio_text(s.recall), s.recalled, s.reappeared);
  text += fmt::format(
      "precision {}: {} correct and {} wrong of {} re-identified corners ({} unscored{})\n", ratio_text(s.precision),
      s.correct, s.wrong, s.reidentified, s.unscored,
      s.unscored_on_occluder > 0 ? fmt::format(", {} of them on the occluder", s.unscored_on_occluder) : "");
  text += fmt::format("lost: {} to occlusion, {} by leaving the image, {} while visible, {} unscored\n", s.lost,
                      s.lost_outside, s.lost_visible, s.lost_unscored);
  text += reasons_as_text(s);
  text += fmt::format("id switches: {}", s.id_switches);
  if (s.drift_median_px)
    text += fmt::format("; drift from the first observation: median {}, 95 % below {}, {:.1f} % beyond the tolerance",
                        pixel_text(s.drift_median_px), pixel_text(s.drift_p95_px), 100.0 * s.drifted_share);
  text += "\n" + lengths_as_text(s);
  if (s.duplicate_ids > 0) text += fmt::format("fault of the tracker: {} ids twice in one frame\n", s.duplicate_ids);
  return text + fmt::format("frames: {}; ground truth: {}\n", s.frame_count, s.ground_truth);
}

std::string scores_as_csv(const TrackScores& scores) {
  std::string text = "frame";
  for (const Column& column : columns) text += fmt::format(",{}", column.name);
  text += "\n";
  for (const FrameScores& row : scores.frames) {
    text += fmt::format("{}", row.index);
    for (const Column& column : columns) text += fmt::format(",{}", row.*column.count);
    text += "\n";
  }
  return text;
}

std::optional<double> score_named(const TrackScores& scores, const std::string& name) {
  const Json json = totals(scores);
  if (const auto found = json.find(name); found != json.end())
    return found->is_null() ? std::nullopt : std::optional(found->get<double>());
  std::vector<std::string> names;
  for (const auto& item : json.items()) names.push_back(item.key());
  throw Error("there is no score '" + name + "'", "--require", did_you_mean(name, names));
}

ScoreLimit parse_limit(const std::string& text) {
  const ScoreLimit limit = read_limit(text, "'recall>=0.7' or 'wrong<=3'");
  score_named(TrackScores{}, limit.name);
  return limit;
}

bool keeps_limit(const TrackScores& scores, const ScoreLimit& limit) {
  return keeps_limit(score_named(scores, limit.name), limit);
}

}  // namespace rastro
