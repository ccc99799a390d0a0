// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/live_statistics.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "rastro/session/live_statistics_json.h"

namespace rastro {
namespace {

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

}  // namespace

nlohmann::ordered_json json_of(const LiveStatistics& statistics) {
  const TimeHistogram& latency = statistics.exposure_to_pose;
  nlohmann::ordered_json dropped{{"method_too_slow", statistics.dropped}, {"lost_by_device", statistics.lost}};
  nlohmann::ordered_json json{{"runs_may_differ", true},
                              {"arrived_frames", statistics.arrived},
                              {"dropped_frames", statistics.dropped + statistics.lost},
                              {"dropped_because", std::move(dropped)},
                              {"stalls", statistics.stalls},
                              {"losses", statistics.losses},
                              {"exposure_to_pose_ms_median", rounded(latency.percentile_ms(0.5))},
                              {"exposure_to_pose_ms_p95", rounded(latency.percentile_ms(0.95))}};
  if (statistics.recording)
    json["recording"] = {{"frames", statistics.recording->frames},
                         {"dropped_frames", statistics.recording->dropped},
                         {"failure", statistics.recording->failure}};
  return json;
}

std::vector<std::pair<std::string, double>> numbers_of(const LiveStatistics& statistics) {
  return {{"live_dropped_frames", static_cast<double>(statistics.dropped + statistics.lost)},
          {"exposure_to_pose_ms_median", statistics.exposure_to_pose.percentile_ms(0.5)},
          {"exposure_to_pose_ms_p95", statistics.exposure_to_pose.percentile_ms(0.95)}};
}

std::string summary_of(const LiveStatistics& statistics) {
  std::string text = fmt::format("{} of {} frames dropped", statistics.dropped, statistics.arrived);
  if (statistics.dropped > 0) text += " (the method was too slow)";
  if (statistics.lost > 0) text += fmt::format(", {} lost by the device", statistics.lost);
  if (statistics.losses + statistics.stalls > 0)
    text += fmt::format(", the source was gone {} and stalled {} time(s)", statistics.losses, statistics.stalls);
  if (statistics.recording) text += fmt::format(", {} recorded", statistics.recording->frames);
  return text + fmt::format("; exposure to pose {:.1f} ms (median), 95 % within {:.1f} ms; runs may differ",
                            statistics.exposure_to_pose.percentile_ms(0.5),
                            statistics.exposure_to_pose.percentile_ms(0.95));
}

}  // namespace rastro
