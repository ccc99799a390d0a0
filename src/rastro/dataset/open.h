// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "rastro/sensor/source.h"

namespace rastro {

struct OpenOptions {
  std::int64_t first_frame = 0;
  std::int64_t end_frame = std::numeric_limits<std::int64_t>::max();  ///< Not included.
  int every = 1;                                                      ///< Keep each n-th frame from first_frame on.
  double rate_hz = 0.0;                             ///< Stamps for data without any; 0 = the format's usual rate.
  std::string camera;                               ///< Which camera is the main one; empty = left or only.
  std::optional<double> field_of_view_deg;          ///< Horizontal; used where there is no calibration.
  std::optional<std::array<double, 4>> intrinsics;  ///< fx fy cx cy; overrides what is found.
  std::string calibration_file;                     ///< Overrides what is found.
  std::optional<double> readout_s;                  ///< Of the rolling shutter; overrides what is found.
  std::optional<double> calibration_error;          ///< CalibratedCamera::calibration_error; overrides what is found.
  bool want_right = false;
  bool want_depth = false;
  bool want_color = false;
  bool raw_depth = false;  ///< Depth as its camera sees it: neither the device nor rastro puts it into the color image.
  int read_ahead = 4;      ///< Frames decoded ahead on a thread of their own; 0 = none.
};

/// Opens a recording, guessing the format from what is there: EuRoC/ASL, TUM RGB-D, KITTI odometry, KITTI raw (synced),
/// a folder or glob of images, a video file, a CARMEN, minesrover or landmark log, MRCLAM, a ROS 1 bag. Throws Error
/// when nothing usable is there, naming what was looked for.
std::unique_ptr<Source> open(const std::string& path, const OpenOptions& options = {});

/// Decodes up to `depth` frames ahead on a thread of its own; order and errors stay as the inner source gives them.
std::unique_ptr<Source> read_ahead(std::unique_ptr<Source> source, int depth);

}  // namespace rastro
