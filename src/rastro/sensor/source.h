// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/camera/camera.h"
#include "rastro/camera/depth_registration.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

struct CalibratedCamera {
  std::string name;                     ///< "cam0", "image_0", "rgb".
  std::optional<Camera> camera;         ///< nullopt: the source has no calibration.
  std::optional<SE3> body_from_camera;  ///< If known (T_BS of EuRoC).
  std::string calibration_file;         ///< Where it was read from, or "published TUM fr1 intrinsics"; empty if none.
  /// Standard deviation of focal length and baseline, or of the scale of depth, as share of them. That of chessboards
  /// and of data sheets is 0.2 to 1 %.
  double calibration_error = 0.005;
};

/// Properties of a source, known before the first frame is read.
struct SourceInfo {
  std::string path;
  std::string format;  ///< "euroc", "tum_rgbd", "kitti_odometry", "kitti_raw", "images", "video", "carmen", ....
  std::vector<CalibratedCamera> cameras;  ///< Left or only one first.
  std::optional<SE3> left_from_right;     ///< Stereo baseline if known.
  std::int64_t frame_count = 0;           ///< -1 if unknown (some videos).
  bool has_depth = false;
  bool has_right = false;
  bool has_image = true;  ///< False for a laser log.
  bool has_scan = false;
  bool has_odometry = false;
  bool has_landmarks = false;
  bool has_imu = false;
  double depth_factor = 0.0;    ///< Raw depth units per meter.
  double depth_offset_m = 0.0;  ///< Was added to each depth: meters = raw / depth_factor + depth_offset_m.
  /// The depth camera whose depth is put into the color image as frames are read; nullopt: it is there already.
  std::optional<DepthRegistration> depth_registration;
  bool has_stamps = true;          ///< False: stamps are computed from --rate.
  Trajectory ground_truth;         ///< Empty if there is none.
  std::string ground_truth_frame;  ///< "body" or "camera".
  std::string ground_truth_file;
  std::vector<std::string> warnings;  ///< One plain line each, from calibration checks and format detection.
};

/// Thrown by Source::next() if no later frame can be used either, as with images of changing size; every other Error of
/// next() concerns one frame only.
class UnusableSource : public Error {
 public:
  using Error::Error;
};

/// A stream of frames in the order of the recording, in constant memory.
class Source {
 public:
  virtual ~Source() = default;
  virtual const SourceInfo& info() const = 0;
  /// The next frame, or nullopt at the end. Throws Error naming the file for a broken image; reading may continue after
  /// it.
  virtual std::optional<Frame> next() = 0;
};

}  // namespace rastro
