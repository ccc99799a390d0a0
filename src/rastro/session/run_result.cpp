// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/run_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/session/live_statistics_json.h"

namespace rastro {
namespace {

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

std::vector<std::string> limit_names() {
  std::vector<std::string> names;
  for (const auto& [name, value] : numbers_of(TrackResult{})) names.push_back(name);
  return names;
}

}  // namespace

std::vector<std::pair<std::string, double>> numbers_of(const TrackResult& result) {
  const auto number = [](std::int64_t count) { return static_cast<double>(count); };
  return {{"frames", number(result.frames)},
          {"skipped_frames", number(result.skipped_frames)},
          {"coverage", result.coverage},
          {"ms_per_frame_mean", result.ms_per_frame_mean},
          {"ms_per_frame_p95", result.ms_per_frame_p95},
          {"peak_memory_mb", result.peak_memory_mb},
          {"features", number(result.features)},
          {"observations", number(result.observations)},
          {"tracked", number(result.tracked)},
          {"reidentified", number(result.reidentified)},
          {"lost", number(result.lost)},
          {"masked", number(result.masked)},
          {"mean_track_length", result.mean_track_length},
          {"unhealthy_frames", number(result.unhealthy_frames)}};
}

std::string to_json(const TrackResult& result) {
  nlohmann::ordered_json json;
  for (const auto& [name, value] : numbers_of(result)) {
    if (value == std::floor(value) && std::abs(value) < 1e15) {
      json[name] = static_cast<std::int64_t>(value);
    } else {
      json[name] = rounded(value);
    }
  }
  if (result.live) json["live"] = json_of(*result.live);
  json["result_sha256"] = result.result_sha256;
  json["options_sha256"] = result.options_sha256;
  json["interrupted"] = result.interrupted;
  json["ended"] = result.ended;
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Limit::Limit(const std::string& text) : text_(text) {
  const auto begin = text.find_first_of("<>");
  const auto end = begin == std::string::npos ? begin : text.find_first_not_of("<>=", begin);
  if (end == std::string::npos) {
    throw Error(fmt::format("'{}' is not a limit", text), "--require", "give it as 'coverage>=95'");
  }
  name_ = trim(std::string_view(text).substr(0, begin));
  comparison_ = text.substr(begin, end - begin);
  const auto bound = parse_finite(std::string_view(text).substr(end));
  const bool known = comparison_ == ">=" || comparison_ == "<=" || comparison_ == ">" || comparison_ == "<";
  if (!bound || !known) throw Error(fmt::format("'{}' is not a limit", text), "--require", "give it as 'coverage>=95'");
  bound_ = *bound;
  const std::vector<std::string> names = limit_names();
  if (std::find(names.begin(), names.end(), name_) == names.end()) {
    throw Error(fmt::format("'{}' is not a value of result.json", name_), "--require", did_you_mean(name_, names));
  }
}

double Limit::value_in(const TrackResult& result) const {
  for (const auto& [name, value] : numbers_of(result)) {
    if (name == name_) return value;
  }
  RASTRO_CHECK(false, "the name was checked when the limit was made");
  return 0.0;
}

bool Limit::kept_by(const TrackResult& result) const {
  const double value = value_in(result);
  if (comparison_ == ">=") return value >= bound_;
  if (comparison_ == "<=") return value <= bound_;
  return comparison_ == ">" ? value > bound_ : value < bound_;
}

std::string Limit::complaint(const TrackResult& result) const {
  return fmt::format("{} missed: it is {}", text_, rounded(value_in(result)));
}

}  // namespace rastro
