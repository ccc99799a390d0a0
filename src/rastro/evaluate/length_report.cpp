// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/length_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "rastro/base/text.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t widest_name = 32;

std::string error_text(const MeasuredLength& one) {
  const auto error = one.error_m();
  if (!error) return fmt::format("{:>9}  {:>8}", "-", "-");
  return fmt::format("{:>+9.4f}  {:>+8.2f}", *error, 100.0 * *error / *one.true_length_m);
}

std::size_t name_width(const std::vector<MapOfLengths>& maps) {
  std::size_t width = 6;
  for (const MapOfLengths& map : maps)
    for (const MeasuredLength& one : map.lengths) width = std::max(width, one.name.size());
  return std::min(width, widest_name);
}

std::string line_of(const MeasuredLength& one, std::size_t width) {
  const std::string ground_truth = one.true_length_m ? fmt::format("{:.4f}", *one.true_length_m) : "-";
  std::string line = one.length_m
                         ? fmt::format("{:<{}}  {:>9.4f}  {:>7.4f}", one.name, width, *one.length_m, one.sigma_m)
                         : fmt::format("{:<{}}  {:>9}  {:>7}", one.name, width, "-", "-");
  line += fmt::format("  {:>8}  {}", ground_truth, error_text(one));
  line += fmt::format("  {:>3} {:>3} {:>3}", one.keyframes_a, one.keyframes_b, one.together);
  if (!one.note.empty()) line += fmt::format("  {}{}", one.length_m ? "" : "not measurable: ", one.note);
  return line + "\n";
}

std::string text_of(const MapOfLengths& map, std::size_t width) {
  std::string text =
      fmt::format("{}\n{:<{}}  {:>9}  {:>7}  {:>8}  {:>9}  {:>8}  keyframes (a, b, both)\n", one_line(map.map),
                  "length", width, "measure m", "sigma m", "true m", "error m", "error %");
  for (const MeasuredLength& one : map.lengths) text += line_of(one, width);
  return text;
}

std::string optional_text(const std::optional<double>& value, const char* form) {
  return value ? fmt::format(fmt::runtime(form), *value) : "-";
}

std::string text_of(const std::vector<LengthSummary>& all, std::size_t width) {
  std::string text = fmt::format("\n{:<{}}  {:>8}  {:>8}  {:>9}  {:>9}  {:>9}  {:>9}  {:>10}\n", "over all maps", width,
                                 "measured", "true m", "mean m", "sigma m", "mean err", "max err", "err/sigma");
  for (const LengthSummary& one : all) {
    text += fmt::format("{:<{}}  {:>8}  {:>8}  {:>9}  {:>9}  {:>9}  {:>9}  {:>10}\n", one.name, width,
                        fmt::format("{}/{}", one.measured, one.maps), optional_text(one.true_length_m, "{:.4f}"),
                        one.measured > 0 ? fmt::format("{:.4f}", one.mean_m) : "-",
                        one.measured > 0 ? fmt::format("{:.4f}", one.mean_sigma_m) : "-",
                        optional_text(one.mean_error_m, "{:.4f}"), optional_text(one.max_error_m, "{:.4f}"),
                        optional_text(one.rms_sigmas, "{:.2f}"));
  }
  return text;
}

Json rounded(double value) { return std::isfinite(value) ? Json(std::round(value * 1e7) / 1e7) : Json(nullptr); }
Json rounded(const std::optional<double>& value) { return value ? rounded(*value) : Json(nullptr); }
Json rounded(const Eigen::Vector3d& point) {
  return Json::array({rounded(point.x()), rounded(point.y()), rounded(point.z())});
}

Json json_of(const MeasuredLength& one) {
  Json json;
  json["name"] = one_line(one.name);
  json["kind"] = name_of(one.kind);
  json["length_m"] = rounded(one.length_m);
  json["sigma_m"] = one.length_m ? rounded(one.sigma_m) : Json(nullptr);
  json["true_m"] = rounded(one.true_length_m);
  json["error_m"] = rounded(one.error_m());
  json["a"] = rounded(one.a);
  json["b"] = rounded(one.b);
  json["direction"] = rounded(one.direction);
  json["keyframes_a"] = one.keyframes_a;
  json["keyframes_b"] = one.keyframes_b;
  json["together"] = one.together;
  json["points"] = one.points;
  json["support"] = rounded(one.support);
  json["scatter_m"] = rounded(one.scatter_m);
  json["note"] = one.note;
  return json;
}

Json json_of(const LengthSummary& one) {
  Json json;
  json["name"] = one_line(one.name);
  json["maps"] = one.maps;
  json["measured"] = one.measured;
  json["true_m"] = rounded(one.true_length_m);
  json["mean_m"] = one.measured > 0 ? rounded(one.mean_m) : Json(nullptr);
  json["mean_sigma_m"] = one.measured > 0 ? rounded(one.mean_sigma_m) : Json(nullptr);
  json["mean_error_m"] = rounded(one.mean_error_m);
  json["max_error_m"] = rounded(one.max_error_m);
  json["rms_sigmas"] = rounded(one.rms_sigmas);
  return json;
}

std::string csv_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char letter : one_line(text)) quoted += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return quoted + "\"";
}

std::string csv_number(const std::optional<double>& value) { return value ? fmt::format("{:.6f}", *value) : ""; }

/// Errors and their ratios to the sigmas.
struct Errors {
  int measured = 0, with_ground_truth = 0;
  double sum = 0.0, sum_sigma = 0.0, sum_absolute = 0.0, largest = 0.0, largest_percent = 0.0, largest_sigma = 0.0,
         squares = 0.0;

  void add(const MeasuredLength& one) {
    if (!one.length_m) return;
    ++measured;
    sum += *one.length_m;
    sum_sigma += one.sigma_m;
    largest_sigma = std::max(largest_sigma, one.sigma_m);
    const auto error = one.error_m();
    if (!error) return;
    ++with_ground_truth;
    sum_absolute += std::abs(*error);
    largest = std::max(largest, std::abs(*error));
    largest_percent = std::max(largest_percent, 100.0 * std::abs(*error) / *one.true_length_m);
    squares += std::pow(*error / one.sigma_m, 2);
  }
  std::optional<double> if_any(double value) const {
    return with_ground_truth > 0 ? std::optional(value) : std::nullopt;
  }
  std::optional<double> mean_error() const { return if_any(sum_absolute / std::max(1, with_ground_truth)); }
  std::optional<double> rms_sigmas() const { return if_any(std::sqrt(squares / std::max(1, with_ground_truth))); }
};

}  // namespace

std::vector<LengthSummary> summarize_lengths(const std::vector<MapOfLengths>& maps) {
  std::vector<LengthSummary> all;
  if (maps.empty()) return all;
  for (std::size_t k = 0; k < maps.front().lengths.size(); ++k) {
    LengthSummary summary;
    summary.name = maps.front().lengths[k].name;
    summary.true_length_m = maps.front().lengths[k].true_length_m;
    Errors errors;
    for (const MapOfLengths& map : maps) ++summary.maps, errors.add(map.lengths[k]);
    summary.measured = errors.measured;
    summary.mean_m = errors.sum / std::max(1, errors.measured);
    summary.mean_sigma_m = errors.sum_sigma / std::max(1, errors.measured);
    summary.mean_error_m = errors.mean_error();
    summary.max_error_m = errors.if_any(errors.largest);
    summary.rms_sigmas = errors.rms_sigmas();
    all.push_back(summary);
  }
  return all;
}

std::string lengths_as_text(const std::vector<MapOfLengths>& maps) {
  const std::size_t width = name_width(maps);
  std::string text;
  for (const MapOfLengths& map : maps) {
    if (!text.empty()) text += '\n';
    text += text_of(map, width);
  }
  if (maps.size() > 1) text += text_of(summarize_lengths(maps), width);
  return text;
}

std::string lengths_as_json(const std::vector<MapOfLengths>& maps) {
  Json json;
  json["maps"] = Json::array();
  for (const MapOfLengths& map : maps) {
    Json lengths = Json::array();
    for (const MeasuredLength& one : map.lengths) lengths.push_back(json_of(one));
    json["maps"].push_back(Json{{"map", one_line(map.map, 1000)}, {"lengths", lengths}});
  }
  json["summary"] = Json::array();
  for (const LengthSummary& one : summarize_lengths(maps)) json["summary"].push_back(json_of(one));
  return json.dump(2) + "\n";
}

std::string lengths_as_csv(const std::vector<MapOfLengths>& maps) {
  std::string text =
      "map,name,kind,length_m,sigma_m,true_m,error_m,keyframes_a,keyframes_b,together,points,support,scatter_m,note\n";
  for (const MapOfLengths& map : maps) {
    for (const MeasuredLength& one : map.lengths) {
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{:.3f},{:.6f},{}\n", csv_text(map.map), csv_text(one.name),
                          name_of(one.kind), csv_number(one.length_m),
                          one.length_m ? csv_number(one.sigma_m) : std::string(), csv_number(one.true_length_m),
                          csv_number(one.error_m()), one.keyframes_a, one.keyframes_b, one.together, one.points,
                          one.support, one.scatter_m, csv_text(one.note));
    }
  }
  return text;
}

std::vector<std::pair<std::string, double>> length_figures(const std::vector<MapOfLengths>& maps) {
  Errors errors;
  int asked = 0;
  for (const MapOfLengths& map : maps)
    for (const MeasuredLength& one : map.lengths) ++asked, errors.add(one);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {{"measured", asked > 0 ? static_cast<double>(errors.measured) / asked : nan},
          {"mean_error_m", errors.mean_error().value_or(nan)},
          {"max_error_m", errors.if_any(errors.largest).value_or(nan)},
          {"max_error_percent", errors.if_any(errors.largest_percent).value_or(nan)},
          {"max_sigma_m", errors.measured > 0 ? errors.largest_sigma : nan},
          {"rms_sigmas", errors.rms_sigmas().value_or(nan)}};
}

}  // namespace rastro
