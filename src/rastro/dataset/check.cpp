// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/dataset/check_scans.h"
#include "rastro/dataset/image_file.h"
#include "rastro/dataset/laser_log/open_log.h"
#include "rastro/dataset/recording.h"
#include "rastro/dataset/video/video.h"
#include "rastro/math/median.h"
#include "rastro/sensor/stamp_text.h"

namespace rastro {
namespace {

using Progress = std::function<void(std::int64_t, std::int64_t)>;

constexpr double longest_usual_step = 1.5;             // Of the median step.
constexpr TimeNs ground_truth_tolerance = 20'000'000;  // At the ends of the trajectory.
constexpr TimeNs shortest_ground_truth_gap =
    200'000'000;                         // Poses farther apart than this (or two steps) say nothing between.
constexpr double fewest_readable = 0.5;  // Share of the images.
constexpr TimeNs bin_width = 5'000'000;  // Of the depth offset histogram.

/// The frames' numbers and stamps, whether they could be read or not.
struct Stamps {
  std::vector<std::int64_t> frames;
  std::vector<TimeNs> stamps;
};

/// Keeps what broke, and says whether the image may be used.
template <typename Read>
auto try_read(CheckReport& report, std::int64_t frame, Read read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const Error& error) {
    report.unreadable_images.push_back({frame, error.what()});
    return std::nullopt;
  }
}

void compare_size(CheckReport& report, std::int64_t frame, int width, int height, const std::string& file) {
  if (report.width == 0) {
    report.width = width;
    report.height = height;
  }
  if (width == report.width && height == report.height) return;
  report.size_changes.push_back(
      {frame, fmt::format("{}: {}x{} instead of {}x{}", file, width, height, report.width, report.height)});
}

void note_depth_offset(CheckReport& report, TimeNs offset) {
  const auto bins = static_cast<TimeNs>(report.depth.depth_offset_histogram.size());
  const TimeNs bin = std::clamp<TimeNs>((offset + bins / 2 * bin_width) / bin_width, 0, bins - 1);
  ++report.depth.depth_offset_histogram[static_cast<std::size_t>(bin)];
  report.depth.depth_offset_max_ms =
      std::max(report.depth.depth_offset_max_ms, std::abs(static_cast<double>(offset)) * 1e-6);
}

class ImageCheck {
 public:
  explicit ImageCheck(CheckReport& report) : report_(report) {}

  void add(std::int64_t index, const RecordedFrame& frame) {
    const auto main = try_read(report_, index, [&] { return read_image(frame.image).gray; });
    if (main) {
      ++report_.frames_read;
      compare_size(report_, index, main->width(), main->height(), frame.image);
    }
    if (!frame.right.empty()) check_right(index, frame);
    if (!frame.depth.empty()) check_depth(index, frame);
  }

  void finish() {
    if (depth_pixels_ > 0.0) report_.depth.depth_measured_percent = 100.0 * depth_measured_ / depth_pixels_;
  }

 private:
  void check_right(std::int64_t index, const RecordedFrame& frame) {
    const auto right = try_read(report_, index, [&] { return read_image(frame.right).gray; });
    if (!right) return;
    ++report_.frames_with_right;
    compare_size(report_, index, right->width(), right->height(), frame.right);
  }

  void check_depth(std::int64_t index, const RecordedFrame& frame) {
    const auto raw = try_read(report_, index, [&] { return read_raw_depth(frame.depth); });
    if (!raw) return;
    ++report_.depth.frames_with_depth;
    if (const auto& other = report_.info.depth_registration) {
      const Camera& camera = other->depth_camera;
      if (raw->width() != camera.width || raw->height() != camera.height)
        report_.size_changes.push_back(
            {index, fmt::format("{}: {}x{}, but depth_camera of the calibration {}x{}", frame.depth, raw->width(),
                                raw->height(), camera.width, camera.height)});
    } else {
      compare_size(report_, index, raw->width(), raw->height(), frame.depth);
    }
    note_depth_offset(report_, frame.depth_stamp - frame.stamp);
    for (int y = 0; y < raw->height(); ++y) {
      for (int x = 0; x < raw->width(); ++x)
        depth_measured_ += raw->at(x, y) != 0 && raw->at(x, y) != 65535 ? 1.0 : 0.0;
    }
    depth_pixels_ += static_cast<double>(raw->width()) * raw->height();
  }

  CheckReport& report_;
  double depth_measured_ = 0.0;
  double depth_pixels_ = 0.0;
};

Stamps check_recording(CheckReport& report, const Recording& recording, const OpenOptions& options,
                       const Progress& progress) {
  const FrameChoice choice(options, static_cast<std::int64_t>(recording.frames.size()), recording.info.path);
  report.frames_chosen = choice.count;
  Stamps stamps;
  ImageCheck images(report);
  for (std::int64_t k = 0; k < choice.count; ++k) {
    const auto index = choice.index(k);
    const auto& frame = recording.frames[static_cast<std::size_t>(index)];
    images.add(index, frame);
    stamps.frames.push_back(index);
    stamps.stamps.push_back(frame.stamp);
    if (progress) progress(k + 1, choice.count);
  }
  images.finish();
  return stamps;
}

TimeNs median_forward_step(const std::vector<TimeNs>& stamps) {
  std::vector<TimeNs> steps;
  for (std::size_t k = 1; k < stamps.size(); ++k) {
    if (stamps[k] > stamps[k - 1]) steps.push_back(stamps[k] - stamps[k - 1]);
  }
  return upper_median_or(std::move(steps), TimeNs{0});
}

/// Some containers only estimate the number of frames, from length and rate: a pause is no end before the time.
bool ends_early(const std::vector<TimeNs>& stamps, std::int64_t frame_count) {
  if (stamps.size() < 2) return true;
  constexpr double share = 0.98;
  const auto step = static_cast<double>(median_forward_step(stamps));
  return static_cast<double>(stamps.back() - stamps.front()) + step < share * step * static_cast<double>(frame_count);
}

Stamps check_video(CheckReport& report, Source& video, const OpenOptions& options, const Progress& progress) {
  Stamps stamps;
  report.frames_chosen = -1;
  try {
    while (const auto frame = video.next()) {
      ++report.frames_read;
      compare_size(report, frame->index, frame->image.width(), frame->image.height(), frame->name);
      stamps.frames.push_back(frame->index);
      stamps.stamps.push_back(frame->stamp);
      if (progress) progress(report.frames_read, report.info.frame_count);
    }
  } catch (const Error& error) {
    report.unreadable_images.push_back({report.frames_read, error.what()});
  }
  report.frames_chosen = report.frames_read;
  const bool chosen = options.first_frame > 0 || options.every > 1 || options.end_frame < report.info.frame_count;
  if (!chosen && report.frames_read < report.info.frame_count && ends_early(stamps.stamps, report.info.frame_count)) {
    report.warnings.push_back(fmt::format("the video ends after {} frames, not {} as in its header", report.frames_read,
                                          report.info.frame_count));
  }
  return stamps;
}

double measured_share(const DepthImage& depth) {
  std::int64_t measured = 0;
  for (int y = 0; y < depth.height(); ++y)
    measured += std::count_if(depth.row(y), depth.row(y) + depth.width(), [](float meters) { return meters > 0.0F; });
  return static_cast<double>(measured) / (static_cast<double>(depth.width()) * depth.height());
}

/// Scans, landmarks and bags: whatever next() gives, going on after broken frames.
Stamps check_log(CheckReport& report, Source& log, const OpenOptions& options, const Progress& progress) {
  const FrameChoice choice(options, report.info.frame_count, report.info.path);
  report.frames_chosen = choice.count;
  Stamps stamps;
  ScanCheck scans(report);
  double measured_percent = 0.0;
  for (std::int64_t k = 0; k < choice.count; ++k) {
    const auto frame = try_read(report, choice.index(k), [&] { return log.next(); });
    if (progress) progress(k + 1, choice.count);
    if (!frame) continue;
    if (!*frame) break;
    ++report.frames_read;
    scans.add(**frame);
    const auto& image = (*frame)->image;
    if (!image.empty()) compare_size(report, (*frame)->index, image.width(), image.height(), (*frame)->name);
    if (const auto& depth = (*frame)->depth; !depth.empty()) {
      ++report.depth.frames_with_depth;
      note_depth_offset(report, (*frame)->depth_stamp - (*frame)->stamp);
      measured_percent += 100.0 * measured_share(depth);
    }
    stamps.frames.push_back((*frame)->index);
    stamps.stamps.push_back((*frame)->stamp);
  }
  scans.finish();
  if (report.depth.frames_with_depth > 0)
    report.depth.depth_measured_percent = measured_percent / static_cast<double>(report.depth.frames_with_depth);
  return stamps;
}

void judge_stamps(CheckReport& report, const Stamps& all) {
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

void judge_unit(CheckReport& report, const Stamps& all) {
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

void judge_ground_truth(CheckReport& report, const Stamps& all) {
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

void warn(CheckReport& report, std::size_t count, const char* what) {
  if (count > 0) report.warnings.push_back(fmt::format("{} {}", count, what));
}

void give_verdict(CheckReport& report, const Stamps& all) {
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

CheckReport check(const std::string& path, const OpenOptions& options, const Progress& progress) {
  CheckReport report;
  Stamps stamps;
  OpenOptions with_depth = options;
  with_depth.want_depth = true;
  if (const auto log = open_log(path, with_depth)) {
    report.info = log->info();
    report.warnings = report.info.warnings;
    report.stamps.stamp_unit = report.info.format == "minesrover" ? "us" : "s";
    stamps = check_log(report, *log, options, progress);
  } else if (auto recording = index_recording(path, options)) {
    report.info = recording->info;
    report.warnings = report.info.warnings;
    report.stamps.stamp_unit = recording->stamp_unit;
    stamps = check_recording(report, *recording, options, progress);
  } else {
    const auto video = open_video(path, options);
    report.info = video->info();
    report.warnings = report.info.warnings;
    report.stamps.stamp_unit = "s";
    stamps = check_video(report, *video, options, progress);
  }
  judge_stamps(report, stamps);
  judge_unit(report, stamps);
  judge_ground_truth(report, stamps);
  give_verdict(report, stamps);
  return report;
}

}  // namespace rastro
