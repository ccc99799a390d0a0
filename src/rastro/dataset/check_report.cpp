// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "rastro/dataset/check.h"
#include "rastro/dataset/describe.h"
#include "rastro/dataset/describe_fields.h"

namespace rastro {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_shown = 5;

void add_line(std::string& text, std::string_view name, const std::string& value) {
  text += fmt::format("{:<14}{}\n", name, value);
}

/// "none", or how many and the first few.
template <typename Item, typename Show>
void add_list(std::string& text, std::string_view name, const std::vector<Item>& items, Show show) {
  add_line(text, name, items.empty() ? "none" : fmt::format("{}", items.size()));
  for (std::size_t k = 0; k < std::min(items.size(), most_shown); ++k) add_line(text, "", show(items[k]));
  if (items.size() > most_shown)
    add_line(text, "", fmt::format("... and {} more (--json lists all)", items.size() - most_shown));
}

std::string show_frame(std::int64_t frame) { return fmt::format("at frame {}", frame); }
std::string show_problem(const FrameProblem& problem) {
  return fmt::format("frame {}: {}", problem.frame, problem.problem);
}
std::string show_gap(const StampGap& gap) {
  return fmt::format("{:.3f} s after frame {}", gap.seconds, gap.after_frame);
}

void add_depth(std::string& text, const CheckReport& report) {
  if (!report.info.has_depth) return;
  add_line(text, "depth images",
           fmt::format("{} of {} frames, {:.0f} % of the pixels measured", report.depth.frames_with_depth,
                       report.frames_chosen, report.depth.depth_measured_percent));
  add_line(text, "depth - rgb",
           fmt::format("at most {:.1f} ms; histogram of 5 ms bins from -20 to 20 ms: {}",
                       report.depth.depth_offset_max_ms, fmt::join(report.depth.depth_offset_histogram, " ")));
}

void add_scans(std::string& text, const CheckReport& report) {
  if (report.scans.first_scan) {
    add_line(text, "beams",
             fmt::format("{:.1f} % returns, {:.1f} % free, {:.1f} % broken", report.scans.returns_percent,
                         report.scans.free_percent, report.scans.broken_percent));
    add_list(text, "no return", report.scans.empty_scans, show_frame);
  }
  if (report.info.has_odometry) {
    add_line(text, "odometry path",
             fmt::format("{:.2f} m over {} frames", report.odometry.odometry_length_m,
                         report.odometry.frames_with_odometry));
    add_list(text, "jumps", report.odometry.odometry_jumps, show_problem);
  }
  if (report.info.has_landmarks)
    add_line(text, "observations", fmt::format("{} of {} landmarks", report.landmark_observations, report.landmarks));
}

void add_stamps(std::string& text, const CheckReport& report) {
  add_line(text, "rate",
           report.info.has_stamps
               ? fmt::format("{:.2f} Hz (median step), {:.2f} s in all, stamps in {}", report.stamps.rate_hz,
                             report.stamps.duration_s, report.stamps.stamp_unit)
               : fmt::format("{:.2f} Hz, made up", report.stamps.rate_hz));
  add_list(text, "gaps", report.stamps.gaps, show_gap);
  add_list(text, "repeated", report.stamps.repeated_stamps, show_frame);
  add_list(text, "backward", report.stamps.backward_stamps, show_frame);
}

Json problems(const std::vector<FrameProblem>& items) {
  Json list = Json::array();
  for (const auto& item : items) list.push_back({{"frame", item.frame}, {"problem", item.problem}});
  return list;
}

}  // namespace

std::string to_text(const CheckReport& report) {
  std::string text = describe(report.info, false, report.scans.first_scan ? &*report.scans.first_scan : nullptr);
  if (report.info.has_image) {
    add_line(
        text, "images",
        fmt::format("{} of {} read, {}x{}", report.frames_read, report.frames_chosen, report.width, report.height));
  } else {
    add_line(text, "read", fmt::format("{} of {}", report.frames_read, report.frames_chosen));
  }
  add_stamps(text, report);
  add_list(text, "unreadable", report.unreadable_images, show_problem);
  add_list(text, "size changes", report.size_changes, show_problem);
  add_list(text, "dark or blank", report.blank_images, show_frame);
  if (report.info.has_right)
    add_line(text, "right images", fmt::format("{} of {} frames", report.frames_with_right, report.frames_chosen));
  add_depth(text, report);
  add_scans(text, report);
  if (!report.info.ground_truth.empty())
    add_line(text, "ground truth", fmt::format("{:.1f} % of the frames", report.ground_truth_percent));
  for (const auto& warning : report.warnings) add_line(text, "warning", warning);
  for (const auto& reason : report.reasons) add_line(text, "reason", reason);
  add_line(text, "verdict",
           !report.usable            ? "cannot be used"
           : report.warnings.empty() ? "good"
                                     : "usable, see the warnings");
  return text;
}

std::string to_json(const CheckReport& report) {
  Json json = source_fields(report.info);
  json["usable"] = report.usable;
  json["reasons"] = report.reasons;
  json["warnings"] = report.warnings;
  json["frames_chosen"] = report.frames_chosen;
  json["frames_read"] = report.frames_read;
  json["width"] = report.width;
  json["height"] = report.height;
  json["rate_hz"] = report.stamps.rate_hz;
  json["duration_s"] = report.stamps.duration_s;
  json["stamp_unit"] = report.stamps.stamp_unit;
  json["gaps"] = Json::array();
  for (const auto& gap : report.stamps.gaps)
    json["gaps"].push_back({{"after_frame", gap.after_frame}, {"seconds", gap.seconds}});
  json["repeated_stamps"] = report.stamps.repeated_stamps;
  json["backward_stamps"] = report.stamps.backward_stamps;
  json["unreadable_images"] = problems(report.unreadable_images);
  json["size_changes"] = problems(report.size_changes);
  json["blank_images"] = report.blank_images;
  json["frames_with_right"] = report.frames_with_right;
  json["frames_with_depth"] = report.depth.frames_with_depth;
  json["depth_offset_histogram"] = report.depth.depth_offset_histogram;
  json["depth_offset_max_ms"] = report.depth.depth_offset_max_ms;
  json["depth_measured_percent"] = report.depth.depth_measured_percent;
  if (report.scans.first_scan) {
    json["scan"] = scan_fields(*report.scans.first_scan);
    json["returns_percent"] = report.scans.returns_percent;
    json["free_percent"] = report.scans.free_percent;
    json["broken_percent"] = report.scans.broken_percent;
    json["empty_scans"] = report.scans.empty_scans;
  }
  json["frames_with_odometry"] = report.odometry.frames_with_odometry;
  json["odometry_length_m"] = report.odometry.odometry_length_m;
  json["odometry_jumps"] = problems(report.odometry.odometry_jumps);
  json["landmark_sightings"] = report.landmark_observations;
  json["landmarks"] = report.landmarks;
  json["ground_truth_percent"] = report.ground_truth_percent;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rastro
