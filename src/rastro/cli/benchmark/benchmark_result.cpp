// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/benchmark/benchmark_result.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"

namespace rastro::cli {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

std::optional<double> optional_in(const Json& json, const char* key) {
  return json.at(key).is_null() ? std::nullopt : std::optional(json.at(key).get<double>());
}

/// JSON knows no NaN: a figure that is none is left out.
std::map<std::string, double> finite(const std::map<std::string, double>& figures) {
  std::map<std::string, double> kept;
  for (const auto& [name, value] : figures)
    if (std::isfinite(value)) kept[name] = value;
  return kept;
}

BenchmarkResult from_json(const Json& json) {
  BenchmarkResult result;
  result.entry = json.at("entry").get<std::string>();
  result.seed = json.at("seed").get<std::uint64_t>();
  result.command = json.at("command").get<std::string>();
  result.program = json.at("program").get<std::string>();
  result.files = json.value("files", std::string());
  result.jobs = json.value("jobs", 0), result.threads = json.value("threads", 0);
  result.failure = json.at("failure").get<std::string>();
  result.message = json.at("message").get<std::string>();
  RunScores& scores = result.scores;
  scores.frames = json.at("frames").get<std::int64_t>();
  scores.tracked = json.at("tracked").get<std::int64_t>();
  scores.posed = json.at("posed").get<std::int64_t>();
  scores.false_poses = json.at("false_poses").get<std::int64_t>();
  scores.false_poses_lost = json.at("false_poses_lost").get<std::int64_t>();
  scores.ate_m = optional_in(json, "ate_m");
  scores.inside_position_percent = optional_in(json, "inside_position_percent");
  scores.inside_rotation_percent = optional_in(json, "inside_rotation_percent");
  scores.warned = json.at("warned").get<bool>();
  scores.sha256 = json.at("sha256").get<std::string>();
  scores.alignment = json.at("alignment").get<std::string>();
  scores.first_loss = json.at("first_loss").get<std::string>();
  scores.figures = json.at("figures").get<std::map<std::string, double>>();
  result.timed_out = json.value("timed_out", false);
  result.wall_s = json.at("wall_s").get<double>();
  result.cpu_s = json.at("cpu_s").get<double>();
  result.peak_memory_mb = json.at("peak_memory_mb").get<double>();
  return result;
}

}  // namespace

std::string to_json(const BenchmarkResult& result) {
  const RunScores& scores = result.scores;
  Json json{{"entry", result.entry},
            {"seed", result.seed},
            {"command", result.command},
            {"program", result.program},
            {"files", result.files},
            {"jobs", result.jobs},
            {"threads", result.threads},
            {"failure", result.failure},
            {"message", result.message},
            {"frames", scores.frames},
            {"tracked", scores.tracked},
            {"posed", scores.posed},
            {"false_poses", scores.false_poses},
            {"false_poses_lost", scores.false_poses_lost},
            {"ate_m", json_of(scores.ate_m)},
            {"inside_position_percent", json_of(scores.inside_position_percent)},
            {"inside_rotation_percent", json_of(scores.inside_rotation_percent)},
            {"warned", scores.warned},
            {"sha256", scores.sha256},
            {"alignment", scores.alignment},
            {"first_loss", scores.first_loss},
            {"figures", finite(scores.figures)},
            {"timed_out", result.timed_out},
            {"wall_s", result.wall_s},
            {"cpu_s", result.cpu_s},
            {"peak_memory_mb", result.peak_memory_mb}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::optional<BenchmarkResult> read_benchmark_result(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return std::nullopt;
  try {
    return from_json(Json::parse(read_whole_file(file)));
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace rastro::cli
