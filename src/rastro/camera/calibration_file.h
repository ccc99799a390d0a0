// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/camera/depth_registration.h"
#include "rastro/math/se3.h"

namespace rastro {

/// One camera of a calibration file.
struct CalibratedCameraEntry {
  /// Name in the file or data set: "cam0" (EuRoC: the folder of sensor.yaml; Kalibr), "image_0" (KITTI odometry),
  /// "image_00" (KITTI raw, rectified) and "image_00_raw" (before rectification), ROS's camera_name, "left", "right".
  std::string name;
  Camera camera;                            ///< Width and height 0 if not in the file.
  std::optional<SE3> body_from_camera;      ///< EuRoC's T_BS; Kalibr: body = IMU, the inverse of T_cam_imu.
  std::optional<SE3> camera_from_previous;  ///< From the frame of the previous entry (Kalibr's T_cn_cnm1).
  std::optional<double> rate_hz;
  std::optional<double> calibration_error;  ///< Standard deviation of focal length and baseline, as share of them.
};

struct Calibration {
  std::string format;                          ///< "euroc", "kitti_odometry", "kitti_raw", "opencv", "ros", "kalibr".
  std::vector<CalibratedCameraEntry> cameras;  ///< At least one.
  /// rastro's own keys depth_camera and color_from_depth of an OpenCV or ROS file: depth is that of another camera.
  std::optional<DepthRegistration> depth;
  /// Doubts about the file, one plain line each without the file's name (baseline sign, transforms that are not quite
  /// rigid). Does not include calibration_warnings() of each camera: call it once the image size is known.
  std::vector<std::string> warnings;
};

/// Reads a calibration file and detects its format: EuRoC sensor.yaml, KITTI odometry calib.txt, KITTI raw
/// calib_cam_to_cam.txt, OpenCV FileStorage YAML, ROS camera_info YAML, Kalibr camchain. Throws Error, naming file,
/// line and key, for anything it cannot use: no file, unknown format or model, missing or misspelled key, NaN, a focal
/// length <= 0.
Calibration read_calibration(const std::string& path);

/// The same for text; `where` names it in messages.
Calibration parse_calibration(std::string_view text, std::string_view where);

/// Whether the text has the keys of a camera in any of these formats, or cannot be told to have none; it may still be
/// wrong in its numbers.
bool holds_camera(std::string_view text);

/// KITTI raw's calib_velo_to_cam.txt (camera_from_velodyne) or calib_imu_to_velo.txt (velodyne_from_imu): the lines R
/// and T.
SE3 read_kitti_transform(const std::string& path);
SE3 parse_kitti_transform(std::string_view text, std::string_view where);
/// R_rect_00 of KITTI raw's calib_cam_to_cam.txt: rectified_from_camera of camera 0. nullopt where there is no such
/// line.
std::optional<SO3> read_kitti_rectification(const std::string& path);

/// The published color camera of TUM RGB-D's "freiburg1", "freiburg2" or "freiburg3" (640x480); nullopt for other
/// names. https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
std::optional<Camera> published_tum_camera(std::string_view name);

}  // namespace rastro
