// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/slam_result.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "rastro/session/live_statistics_json.h"
#include "rastro/session/watched_input.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;

constexpr double bytes_per_mb = 1e6;

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

Json number(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<std::int64_t>(value);
  return rounded(value);
}

Json stages_of(const SlamResult& result) {
  Json stages = Json::object();
  for (const SlamStage& stage : result.timing.stages) {
    stages[stage.name] = {{"frames", stage.times.count()},
                          {"ms_mean", rounded(stage.times.mean_ms())},
                          {"ms_p95", rounded(stage.times.percentile_ms(0.95))}};
  }
  return stages;
}

}  // namespace

std::optional<double> SlamTiming::times_real_time() const {
  if (!(method_seconds > 0.0) || !(recording_seconds > 0.0)) return std::nullopt;
  return recording_seconds / method_seconds;
}

std::vector<std::pair<std::string, double>> numbers_of(const SlamResult& result) {
  const auto count = [](std::int64_t value) { return static_cast<double>(value); };
  return {{"frames", count(result.frames)},
          {"skipped_frames", count(result.skipped_frames)},
          {"dropped_frames", count(result.timing.dropped_frames)},
          {"coverage", result.coverage},
          {"recall", result.recall},
          {"seconds_to_first_pose", result.seconds_to_first_pose.value_or(-1.0)},
          {"tracking", count(result.states.tracking)},
          {"weak", count(result.states.weak)},
          {"lost", count(result.states.lost)},
          {"relocalized", count(result.states.relocalized)},
          {"initializing", count(result.states.initializing)},
          {"loops_closed", count(result.loops_closed)},
          {"keyframes", count(result.keyframes)},
          {"submaps", count(result.submaps)},
          {"landmarks", count(result.landmarks)},
          {"path_length", result.path_length},
          {"ms_per_frame_mean", result.timing.frames.mean_ms()},
          {"ms_per_frame_p95", result.timing.frames.percentile_ms(0.95)},
          {"times_real_time", result.timing.times_real_time().value_or(0.0)},
          {"peak_memory_mb", result.memory.peak_mb},
          {"map_memory_mb", static_cast<double>(result.memory.map.bytes) / bytes_per_mb}};
}

std::vector<std::pair<std::string, double>> limit_numbers_of(const SlamResult& result) {
  auto numbers = numbers_of(result);
  for (auto& live : numbers_of(result.timing.live.value_or(LiveStatistics{}))) numbers.push_back(std::move(live));
  return numbers;
}

std::string to_json(const SlamResult& result) {
  Json json{{"method", result.method.name}};
  if (!result.method.choice.empty()) json["method_choice"] = result.method.choice;
  for (const auto& [name, value] : numbers_of(result)) json[name] = number(value);
  if (result.scale)
    json["scale"] = {{"metric", result.scale->metric},
                     {"relative_sigma", result.scale->relative_sigma},
                     {"from", result.scale->origin}};
  if (result.memory.map.budget_bytes > 0)
    json["map_memory_budget_mb"] = rounded(static_cast<double>(result.memory.map.budget_bytes) / bytes_per_mb);
  if (!result.memory.map.measures.empty()) json["map_memory_measures"] = result.memory.map.measures;
  json["reasons"] = result.reasons;
  json["warnings"] = json_of(result.warnings);
  if (result.timing.live) json["live"] = json_of(*result.timing.live);
  json["stages"] = stages_of(result);
  json["result_sha256"] = result.result_sha256;
  json["interrupted"] = result.interrupted;
  json["ended"] = result.ended;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rastro
