// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/check_judgment.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/math/median.h"
#include "rastro/sensor/stamp_text.h"
#include "rastro/sensor/stereo_pair.h"

namespace rastro {
namespace {

constexpr double longest_usual_step = 1.5;             // Of the median step.
constexpr TimeNs ground_truth_tolerance = 20'000'000;  // At the ends of the trajectory.
constexpr TimeNs shortest_ground_truth_gap =
    200'000'000;                         // Poses farther apart than this (or two steps) say nothing between.
constexpr double fewest_readable = 0.5;  // Share of the images.

void judge_stamps(CheckReport& report, const FrameStamps& all) {
  const auto& stamps = all.stamps;
  const TimeNs median = median_forward_step(stamps);
  if (median > 0) report.stamps.rate_hz = 1e9 / static_cast<double>(median);
  if (!stamps.empty()) {
    const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end());
    report.stamps.duration_s = to_seconds(*last - *first);
  }
  for (std::size_t k = 1; k < stamps.size(); ++k) {
    if (stamps[k] == stamps[k - 1]) report.stamps.repeated_stamps.push_back(all.frames[k]);
    if (stamps[k] < stamps[k - 1]) report.stamps.backward_stamps.push_back(all.frames[k]);
    const double step = static_cast<double>(stamps[k]) - static_cast<double>(stamps[k - 1]);
    if (step > longest_usual_step * static_cast<double>(median))
      report.stamps.gaps.push_back({all.frames[k - 1], step * 1e-9});
  }
}

void judge_unit(CheckReport& report, const FrameStamps& all) {
  if (!report.info.has_stamps) {
    report.stamps.stamp_unit.clear();
    return;
  }
  std::vector<double> seconds;
  for (const auto stamp : all.stamps) seconds.push_back(to_seconds(stamp));
  const auto guess = guess_stamp_unit(seconds, StampUnit::seconds);
  if (guess == StampUnit::seconds) return;
  report.warnings.push_back(fmt::format("one frame per {:g} s: as if timestamps of {} were read as s",
                                        1.0 / report.stamps.rate_hz, unit_name(guess)));
}

void judge_ground_truth(CheckReport& report, const FrameStamps& all) {
  const auto& ground_truth = report.info.ground_truth;
  if (ground_truth.empty() || all.stamps.empty()) return;
  const TimeNs max_gap = std::max(shortest_ground_truth_gap, 2 * median_forward_step(all.stamps));
  const auto covered = std::count_if(all.stamps.begin(), all.stamps.end(), [&](TimeNs stamp) {
    const double before = static_cast<double>(ground_truth.front().stamp) - static_cast<double>(stamp);
    const double behind = static_cast<double>(stamp) - static_cast<double>(ground_truth.back().stamp);
    const double outside = std::max(before, behind);
    return outside <= 0.0 ? pose_at(ground_truth, stamp, max_gap).has_value()
                          : outside <= static_cast<double>(ground_truth_tolerance);
  });
  report.ground_truth_percent = 100.0 * static_cast<double>(covered) / static_cast<double>(all.stamps.size());
  if (report.ground_truth_percent < 90.0) {
    report.warnings.push_back(
        fmt::format("only {:.1f} % of the frames have ground truth", report.ground_truth_percent));
  }
}

/// A pair that every method would refuse, or use the left image of.
void judge_pair(CheckReport& report) {
  if (!report.info.has_right || !has_calibrated_pair(report.info) || stereo_pair(report.info)) return;
  report.warnings.emplace_back(
      "the stereo images cannot be used as a pair: by the calibration the cameras are not side by side, or their sizes "
      "are not in it; check the extrinsics (left_from_right)");
}

/// A covered camera for a moment is no fault of the recording.
void judge_blank_images(CheckReport& report) {
  constexpr double share = 0.02;
  const auto blank = static_cast<double>(report.blank_images.size()), read = static_cast<double>(report.frames_read);
  if (blank == 0.0 || blank < share * read) return;
  report.warnings.push_back(fmt::format(
      "{} of {} images are dark or blank, and of no use to any method{}", report.blank_images.size(),
      report.frames_read, blank == read ? "; images of 16 bits must use the whole range, up to 65535" : ""));
}

void warn(CheckReport& report, std::size_t count, const char* what) {
  if (count > 0) report.warnings.push_back(fmt::format("{} {}", count, what));
}

void give_verdict(CheckReport& report, const FrameStamps& all) {
  warn(report, report.unreadable_images.size(),
       report.info.has_image ? "images cannot be read" : "frames cannot be read");
  warn(report, report.stamps.gaps.size(), "gaps between frames");
  warn(report, report.stamps.repeated_stamps.size(), "stamps are repeated");
  warn(report, report.stamps.backward_stamps.size(), "stamps go backward");
  if (report.frames_read == 1) report.warnings.push_back("only one frame can be read");
  const auto frames = static_cast<double>(all.stamps.size());
  if (report.frames_read == 0) {
    report.reasons.push_back("no frame can be read");
  } else if (static_cast<double>(report.frames_read) < fewest_readable * frames) {
    report.reasons.push_back(fmt::format("only {} of {} frames can be read", report.frames_read, all.stamps.size()));
  }
  if (!report.size_changes.empty() && !report.info.has_image) {
    report.warnings.push_back(
        fmt::format("the scans change their shape, first at frame {}", report.size_changes.front().frame));
  } else if (!report.size_changes.empty()) {
    report.reasons.push_back(
        fmt::format("the images change their size, first at {}", report.size_changes.front().problem));
  }
  const auto bad_steps = report.stamps.repeated_stamps.size() + report.stamps.backward_stamps.size();
  if (static_cast<double>(bad_steps) > fewest_readable * frames) {
    report.reasons.push_back(
        fmt::format("the stamps do not rise: {} of {} repeat or go backward", bad_steps, all.stamps.size()));
  }
  report.usable = report.reasons.empty();
}

}  // namespace

TimeNs median_forward_step(const std::vector<TimeNs>& stamps) {
  std::vector<TimeNs> steps;
  for (std::size_t k = 1; k < stamps.size(); ++k) {
    if (stamps[k] > stamps[k - 1]) steps.push_back(stamps[k] - stamps[k - 1]);
  }
  return upper_median_or(std::move(steps), TimeNs{0});
}

void judge(CheckReport& report, const FrameStamps& all) {
  judge_stamps(report, all);
  judge_unit(report, all);
  judge_ground_truth(report, all);
  judge_pair(report);
  judge_blank_images(report);
  give_verdict(report, all);
}

}  // namespace rastro
