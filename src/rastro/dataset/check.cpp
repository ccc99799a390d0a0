// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/dataset/check_judgment.h"
#include "rastro/dataset/check_scans.h"
#include "rastro/dataset/image_file.h"
#include "rastro/dataset/laser_log/open_log.h"
#include "rastro/dataset/recording.h"
#include "rastro/dataset/video/video.h"

namespace rastro {
namespace {

using Progress = std::function<void(std::int64_t, std::int64_t)>;

constexpr TimeNs bin_width = 5'000'000;  // Of the depth offset histogram.

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

/// As the methods judge it: the standard deviation of the intensities.
void note_blank(CheckReport& report, std::int64_t frame, GrayView image) {
  constexpr double least_deviation = 5.0;
  double sum = 0.0, squares = 0.0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double value = image.row(y)[x];
      sum += value, squares += value * value;
    }
  const double pixels = static_cast<double>(image.width) * image.height, mean = sum / pixels;
  if (squares / pixels - mean * mean < least_deviation * least_deviation) report.blank_images.push_back(frame);
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
      note_blank(report_, index, *main);
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

FrameStamps check_recording(CheckReport& report, const Recording& recording, const OpenOptions& options,
                            const Progress& progress) {
  const FrameChoice choice(options, static_cast<std::int64_t>(recording.frames.size()), recording.info.path);
  report.frames_chosen = choice.count;
  FrameStamps stamps;
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

/// Some containers only estimate the number of frames, from length and rate: a pause is no end before the time.
bool ends_early(const std::vector<TimeNs>& stamps, std::int64_t frame_count) {
  if (stamps.size() < 2) return true;
  constexpr double share = 0.98;
  const auto step = static_cast<double>(median_forward_step(stamps));
  return static_cast<double>(stamps.back() - stamps.front()) + step < share * step * static_cast<double>(frame_count);
}

FrameStamps check_video(CheckReport& report, Source& video, const OpenOptions& options, const Progress& progress) {
  FrameStamps stamps;
  report.frames_chosen = -1;
  try {
    while (const auto frame = video.next()) {
      ++report.frames_read;
      compare_size(report, frame->index, frame->image.width(), frame->image.height(), frame->name);
      note_blank(report, frame->index, frame->image);
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
FrameStamps check_log(CheckReport& report, Source& log, const OpenOptions& options, const Progress& progress) {
  const FrameChoice choice(options, report.info.frame_count, report.info.path);
  report.frames_chosen = choice.count;
  FrameStamps stamps;
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
    if (!image.empty()) {
      compare_size(report, (*frame)->index, image.width(), image.height(), (*frame)->name);
      note_blank(report, (*frame)->index, image);
    }
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

}  // namespace

CheckReport check(const std::string& path, const OpenOptions& options, const Progress& progress) {
  CheckReport report;
  FrameStamps stamps;
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
  judge(report, stamps);
  return report;
}

}  // namespace rastro
