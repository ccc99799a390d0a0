// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "rastro/dataset/open.h"

namespace rastro {

/// A step between two frames that is much longer than the usual one.
struct StampGap {
  std::int64_t after_frame = 0;
  double seconds = 0.0;
};

/// What is wrong with one frame.
struct FrameProblem {
  std::int64_t frame = 0;
  std::string problem;  ///< One line, naming the file.
};

/// Of the stamps of all chosen frames.
struct StampFindings {
  double rate_hz = 0.0;  ///< 1 / median step; 0 with fewer than two frames.
  double duration_s = 0.0;
  std::vector<StampGap> gaps;                 ///< Steps above 1.5 times the median.
  std::vector<std::int64_t> repeated_stamps;  ///< Frames whose stamp equals that of the frame before.
  std::vector<std::int64_t> backward_stamps;  ///< Frames whose stamp is earlier than that of the frame before.
  std::string stamp_unit;  ///< What they are written in ("s", "ms", "us", "ns", "date"); "" where made up.
};

/// Of depth images.
struct DepthFindings {
  std::int64_t frames_with_depth = 0;
  /// Depth stamp minus color stamp in bins of 5 ms, from -20 to 20 ms; and the largest offset.
  std::array<std::int64_t, 8> depth_offset_histogram{};
  double depth_offset_max_ms = 0.0;
  double depth_measured_percent = 0.0;  ///< Pixels with a measurement, mean over the depth images.
};

/// Of laser scans; a change of their geometry is among size_changes.
struct ScanFindings {
  std::optional<LaserScan> first_scan;
  double returns_percent = 0.0;           ///< Of all beams: something was measured,
  double free_percent = 0.0;              ///< nothing stood within reach,
  double broken_percent = 0.0;            ///< or the beam says nothing.
  std::vector<std::int64_t> empty_scans;  ///< Frames whose scan has not one return.
};

/// Of odometry.
struct OdometryFindings {
  std::int64_t frames_with_odometry = 0;
  double odometry_length_m = 0.0;            ///< Of the path through all read frames.
  std::vector<FrameProblem> odometry_jumps;  ///< Steps that no wheels take: from the frame before to this one.
};

/// What check() found; lists hold all findings, the text form shows the first few of each.
struct CheckReport {
  SourceInfo info;
  std::int64_t frames_chosen = 0;  ///< After --frames and --every; -1 where a video does not say.
  std::int64_t frames_read = 0;    ///< Without an Error.
  int width = 0, height = 0;       ///< Of the first image that could be read.

  StampFindings stamps;
  std::vector<FrameProblem> unreadable_images;  ///< Color or gray, right and depth.
  std::vector<FrameProblem> size_changes;
  std::vector<std::int64_t> blank_images;  ///< Frames whose intensities hardly vary: dark, covered or overexposed.

  std::int64_t frames_with_right = 0;
  DepthFindings depth;
  ScanFindings scans;
  OdometryFindings odometry;
  std::int64_t landmark_observations = 0;
  std::int64_t landmarks = 0;  ///< Different ones, where the sensor tells them apart.

  double ground_truth_percent = 0.0;  ///< Frames with a pose of the ground truth at their stamp.

  bool usable = true;
  std::vector<std::string> reasons;   ///< Why it cannot be used, one line each.
  std::vector<std::string> warnings;  ///< What a user should look at, one line each.
};

/// Opens a recording and decodes every chosen image, scan or observation, going on after broken ones. `progress` is
/// called with the number of frames looked at and of all (-1 = unknown). Error only where open() throws one.
CheckReport check(const std::string& path, const OpenOptions& options,
                  const std::function<void(std::int64_t, std::int64_t)>& progress = {});

/// For people; ends with a verdict.
std::string to_text(const CheckReport& report);
/// For programs; the keys are the names of the members above.
std::string to_json(const CheckReport& report);

}  // namespace rastro
