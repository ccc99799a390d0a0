// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/trajectory_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "rastro/base/error.h"
#include "rastro/base/text.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;

constexpr double same_coverage_percent = 1.0;

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

std::optional<double> part(const std::optional<ErrorStatistics>& statistics, double ErrorStatistics::*member) {
  return statistics ? std::optional((*statistics).*member) : std::nullopt;
}

Json as_json(const std::optional<ErrorStatistics>& s) {
  if (!s) return nullptr;
  return {{"count", s->count},   {"rmse", s->rmse}, {"mean", s->mean},
          {"median", s->median}, {"max", s->max},   {"min", s->min}};
}

/// All scalar figures, in the order they are written; the relative errors are those of the first delta.
Json totals(const TrajectoryScores& s) {
  Json json;
  json["matched"] = s.pairing.matched;
  json["estimate_poses"] = s.pairing.estimate_poses;
  json["reference_poses"] = s.pairing.reference_poses;
  json["coverage"] = s.pairing.coverage_percent;
  json["scale"] = s.scale();
  json["ate_rmse"] = number_or_null(part(s.ate_m, &ErrorStatistics::rmse));
  json["ate_mean"] = number_or_null(part(s.ate_m, &ErrorStatistics::mean));
  json["ate_median"] = number_or_null(part(s.ate_m, &ErrorStatistics::median));
  json["ate_max"] = number_or_null(part(s.ate_m, &ErrorStatistics::max));
  json["ate_min"] = number_or_null(part(s.ate_m, &ErrorStatistics::min));
  const RpeScores first = s.rpe.empty() ? RpeScores{} : s.rpe.front();
  json["rpe_trans_rmse"] = number_or_null(part(first.translation_m, &ErrorStatistics::rmse));
  json["rpe_trans_mean"] = number_or_null(part(first.translation_m, &ErrorStatistics::mean));
  json["rpe_trans_median"] = number_or_null(part(first.translation_m, &ErrorStatistics::median));
  json["rpe_trans_max"] = number_or_null(part(first.translation_m, &ErrorStatistics::max));
  json["rpe_rot_rmse_deg"] = number_or_null(part(first.rotation_deg, &ErrorStatistics::rmse));
  json["t_rel_percent"] = number_or_null(s.t_rel_percent);
  json["r_rel_deg_per_m"] = number_or_null(s.r_rel_deg_per_m);
  json["segment_count"] = s.segment_count;
  json["drift_percent"] = number_or_null(s.drift_percent);
  json["drift_deg_per_m"] = number_or_null(s.drift_deg_per_m);
  for (const auto& [name, part] :
       {std::pair("position", &s.consistency.position), std::pair("rotation", &s.consistency.rotation)}) {
    json[fmt::format("inside_95_{}_percent", name)] = *part ? Json((*part)->inside_percent) : Json(nullptr);
    json[fmt::format("nees_{}", name)] = *part ? Json((*part)->nees) : Json(nullptr);
    json[fmt::format("sigma_factor_{}", name)] = *part ? Json((*part)->sigma_factor) : Json(nullptr);
  }
  json["reference_path_m"] = s.reference_path_m;
  json["estimate_path_m"] = s.estimate_path_m;
  json["largest_dt_s"] = s.pairing.largest_difference_s;
  return json;
}

Json relative_errors_as_json(const TrajectoryScores& s) {
  Json all = Json::array();
  for (const RpeScores& rpe : s.rpe)
    all.push_back({{"delta", as_text(rpe.delta)},
                   {"translation_m", as_json(rpe.translation_m)},
                   {"rotation_deg", as_json(rpe.rotation_deg)}});
  return all;
}

Json segments_as_json(const TrajectoryScores& s) {
  Json all = Json::array();
  for (const SegmentErrors& segments : s.segments) {
    const bool any = segments.count > 0;
    all.push_back({{"length_m", segments.length_m},
                   {"count", segments.count},
                   {"t_percent", any ? Json(segments.translation_percent) : Json(nullptr)},
                   {"r_deg_per_m", any ? Json(segments.rotation_deg_per_m) : Json(nullptr)}});
  }
  return all;
}

Json whole_json(const TrajectoryScores& s) {
  Json json;
  json["reference"] = one_line(s.reference);
  json["estimate"] = one_line(s.estimate);
  json["frames"] = one_line(s.frames, 500);
  json["paired_by"] = s.pairing.by_index ? "line" : "stamp";
  json["alignment"] = name_of(s.alignment);
  json["alignment_unique"] = s.alignment_unique;
  json.update(totals(s));
  json["rpe_delta"] = s.rpe.empty() ? Json(nullptr) : Json(as_text(s.rpe.front().delta));
  json["rpe"] = relative_errors_as_json(s);
  json["segments"] = segments_as_json(s);
  return json;
}

std::string statistics_text(const std::optional<ErrorStatistics>& s, const char* unit) {
  if (!s) return "n/a";
  return fmt::format("rmse {0:.6f} {5}, mean {1:.6f}, median {2:.6f}, max {3:.6f}, min {4:.6f}", s->rmse, s->mean,
                     s->median, s->max, s->min, unit);
}

std::string alignment_text(const TrajectoryScores& s) {
  std::string text;
  switch (s.alignment) {
    case TrajectoryAlignment::none:
      text = "none: not aligned, scale 1";
      break;
    case TrajectoryAlignment::se3:
      text = "se3: rotation and translation, scale 1 (not estimated)";
      break;
    case TrajectoryAlignment::sim3:
      text = fmt::format("sim3: rotation, translation and scale {:.9f}", s.scale());
      break;
    case TrajectoryAlignment::yaw:
      text = "yaw: rotation about the reference's z axis and translation, scale 1 (not estimated)";
      break;
    case TrajectoryAlignment::origin:
      text = "origin: the first matched pose, scale 1 (not estimated)";
      break;
  }
  if (s.alignment_unique) return text;
  if (s.reference_path_m == 0.0 || s.estimate_path_m == 0.0)
    return text + "; one of the two does not move, so the rotation is undetermined";
  return text + "; the positions lie on one line, so the rotation about it is undetermined";
}

std::string segments_text(const TrajectoryScores& s) {
  if (s.segment_count == 0)
    return fmt::format("segments    n/a: none of the lengths fits a path of {:.1f} m (--segments)\n",
                       s.reference_path_m);
  std::string text = fmt::format("segments    t_rel {:.6f} %, r_rel {:.8f} deg/m over {} segments\n", *s.t_rel_percent,
                                 *s.r_rel_deg_per_m, s.segment_count);
  for (const SegmentErrors& segments : s.segments)
    if (segments.count > 0)
      text += fmt::format("  {:>6g} m  {:.6f} %, {:.8f} deg/m, {} segments\n", segments.length_m,
                          segments.translation_percent, segments.rotation_deg_per_m, segments.count);
  return text;
}

std::string consistency_text(const char* name, const std::optional<ConsistencyOfPart>& part) {
  if (!part) return "";
  return fmt::format("  {:<9} {:.1f} % of {} inside the 95 % ellipse, NEES {:.3g}, sigmas x {:.2f} would hold 95 %\n",
                     name, part->inside_percent, part->poses, part->nees, part->sigma_factor);
}

std::string consistency_text(const PoseConsistency& consistency) {
  if (!consistency.position && !consistency.rotation) return "";
  return "covariances of the poses as first given, from the run's origin on\n" +
         consistency_text("position", consistency.position) + consistency_text("rotation", consistency.rotation);
}

std::string cell(const std::optional<double>& value, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value) : "n/a";
}

std::string table_row(const TrajectoryScores& s) {
  const RpeScores first = s.rpe.empty() ? RpeScores{} : s.rpe.front();
  return fmt::format(
      "{:>7}  {:>6.1f} %  {:>9.5f}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>8}  {:>9}  {:>7}  {}\n",
      s.pairing.matched, s.pairing.coverage_percent, s.scale(), cell(part(s.ate_m, &ErrorStatistics::rmse), "{:.4f}"),
      cell(part(s.ate_m, &ErrorStatistics::mean), "{:.4f}"), cell(part(s.ate_m, &ErrorStatistics::median), "{:.4f}"),
      cell(part(s.ate_m, &ErrorStatistics::max), "{:.4f}"),
      cell(part(first.translation_m, &ErrorStatistics::rmse), "{:.4f}"),
      cell(part(first.rotation_deg, &ErrorStatistics::rmse), "{:.4f}"), cell(s.t_rel_percent, "{:.3f}"),
      cell(s.r_rel_deg_per_m, "{:.5f}"), cell(s.drift_percent, "{:.2f}"), one_line(s.estimate));
}

}  // namespace

std::string trajectory_scores_as_text(const TrajectoryScores& s) {
  std::string text =
      fmt::format("matched     {} of {} poses of the estimate with {} of {} of the reference, {}\n", s.pairing.matched,
                  s.pairing.estimate_poses, s.pairing.matched, s.pairing.reference_poses,
                  s.pairing.by_index ? "line by line"
                                     : fmt::format("stamps at most {:.6f} s apart", s.pairing.largest_difference_s));
  text += fmt::format("coverage    {:.2f} % of the reference\n", s.pairing.coverage_percent);
  text += fmt::format("alignment   {}\n", alignment_text(s));
  text += fmt::format("ATE         {}\n", statistics_text(s.ate_m, "m"));
  for (const RpeScores& rpe : s.rpe) {
    text += fmt::format("RPE {:<7} {} ({} pairs)\n", as_text(rpe.delta), statistics_text(rpe.translation_m, "m"),
                        rpe.translation_m ? rpe.translation_m->count : 0);
    if (rpe.rotation_deg) text += fmt::format("            {}\n", statistics_text(rpe.rotation_deg, "deg"));
  }
  text += segments_text(s);
  if (s.drift_percent)
    text += fmt::format("drift       {:.4f} % and {:.6f} deg/m from the first to the last pose\n", *s.drift_percent,
                        *s.drift_deg_per_m);
  text += consistency_text(s.consistency);
  return text + fmt::format("path        {:.3f} m of the reference, {:.3f} m of the estimate\n", s.reference_path_m,
                            s.estimate_path_m);
}

std::string trajectory_scores_as_table(const std::vector<TrajectoryScores>& all) {
  if (all.empty()) return "";
  const std::string delta = all.front().rpe.empty() ? "" : as_text(all.front().rpe.front().delta);
  std::string text =
      fmt::format("alignment {}; ATE in m, RPE over {} in m and deg, t_rel and drift in %, r_rel in deg/m\n",
                  name_of(all.front().alignment), delta);
  text += fmt::format("{:>7}  {:>8}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}  {:>8}  {:>9}  {:>7}  {}\n",
                      "matched", "coverage", "scale", "ATE rmse", "mean", "median", "max", "RPE trans", "RPE rot",
                      "t_rel", "r_rel", "drift", "estimate");
  for (const TrajectoryScores& scores : all) text += table_row(scores);
  const auto [least, most] =
      std::minmax_element(all.begin(), all.end(), [](const TrajectoryScores& a, const TrajectoryScores& b) {
        return a.pairing.coverage_percent < b.pairing.coverage_percent;
      });
  if (most->pairing.coverage_percent - least->pairing.coverage_percent > same_coverage_percent)
    text +=
        fmt::format("coverage differs ({:.1f} to {:.1f} %): the errors are over different poses: do not rank them\n",
                    least->pairing.coverage_percent, most->pairing.coverage_percent);
  return text;
}

std::string trajectory_scores_as_json(const std::vector<TrajectoryScores>& all) {
  if (all.size() == 1) return whole_json(all.front()).dump(2) + "\n";
  Json array = Json::array();
  for (const TrajectoryScores& scores : all) array.push_back(whole_json(scores));
  return array.dump(2) + "\n";
}

std::optional<double> trajectory_score_named(const TrajectoryScores& scores, const std::string& name) {
  const Json json = totals(scores);
  if (const auto found = json.find(name); found != json.end())
    return found->is_null() ? std::nullopt : std::optional(found->get<double>());
  std::vector<std::string> names;
  for (const auto& item : json.items()) names.push_back(item.key());
  throw Error("there is no figure " + in_quotes(name), "--require", did_you_mean(name, names));
}

ScoreLimit parse_trajectory_limit(const std::string& text) {
  const ScoreLimit limit = read_limit(text, "'ate_rmse<=0.3' or 'coverage>=95'");
  trajectory_score_named(TrajectoryScores{}, limit.name);
  return limit;
}

}  // namespace rastro
