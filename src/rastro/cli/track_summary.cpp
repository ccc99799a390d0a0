// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/track_summary.h"

#include <fmt/format.h>

namespace rastro::cli {
namespace {

std::string per_frame(std::int64_t total, std::int64_t frames) {
  return frames > 0 ? fmt::format("{:.1f} per frame", static_cast<double>(total) / static_cast<double>(frames)) : "-";
}

std::string reidentified_percent(const TrackResult& result) {
  const std::int64_t detected = result.reidentified + result.features;
  if (detected == 0) return "";
  return fmt::format(", {:.1f} % of the corners detected",
                     100.0 * static_cast<double>(result.reidentified) / static_cast<double>(detected));
}

}  // namespace

std::vector<std::string> hints_for(const TrackRunEnd& end) {
  const TrackResult& result = end.result;
  std::vector<std::string> hints;
  if (result.skipped_frames > 0) {
    hints.push_back(fmt::format(
        "{} frames could not be read and were skipped, the first: {}. 'rastro check' and events.jsonl list them",
        result.skipped_frames, end.first_skip));
  }
  if (result.frames == 1)
    hints.push_back("one frame only: features were detected, but there is no second frame to track them in");
  if (result.frames > 1 && 2 * result.unhealthy_frames > result.frames) {
    hints.push_back(
        fmt::format("{} of {} frames had fewer features than requested or abrupt motion: see events.jsonl; try --set "
                    "equalize=true for dark images, a smaller min_distance_px, or fewer --features",
                    result.unhealthy_frames, result.frames));
  }
  return hints;
}

std::string track_summary(const TrackRunEnd& end, const std::string& folder,
                          const std::vector<std::pair<std::string, std::string>>& contents,
                          const std::vector<std::string>& hints) {
  const TrackResult& result = end.result;
  std::string text = fmt::format("{} frames tracked, {:.1f} % of the requested ones{}\n", result.frames,
                                 result.coverage, result.interrupted ? " (interrupted)" : "");
  text += fmt::format("  features       {} ids, mean track length {:.1f} frames\n", result.features,
                      result.mean_track_length);
  text += fmt::format("  tracked        {}\n", per_frame(result.tracked, result.frames));
  text += fmt::format("  re-identified  {} ({}{})\n", result.reidentified,
                      per_frame(result.reidentified, result.frames), reidentified_percent(result));
  text += fmt::format("  time           {:.2f} ms per frame, 95 % within {:.2f} ms; memory {:.0f} MB\n",
                      result.ms_per_frame_mean, result.ms_per_frame_p95, result.peak_memory_mb);
  if (result.live) text += "  live           " + summary_of(*result.live) + "\n";
  text += fmt::format("  result         sha256 {}\n", result.result_sha256);
  text += fmt::format("written to {}:\n", folder);
  for (const auto& [file, what] : contents) text += fmt::format("  {:<36} {}\n", file, what);
  text += fmt::format("  {:<36} {}\n", "result.json stats.csv", "statistics of the run and of each frame");
  for (const std::string& hint : hints) text += "warning: " + hint + "\n";
  return text;
}

}  // namespace rastro::cli
