// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/camera/calibration_file.h"

/// The readers of the formats and what they share. Internal parts of calibration_file.h.
namespace rastro::calibration {

class YamlFields;

bool is_euroc(const YamlFields& root);
Calibration parse_euroc(const YamlFields& root);
bool is_kalibr(const YamlFields& root);
Calibration parse_kalibr(const YamlFields& root);
/// OpenCV's FileStorage (one camera, or M1 D1 M2 D2 of a stereo pair), ROS camera_info files, and printed CameraInfo
/// messages.
bool is_opencv_or_ros(const YamlFields& root);
Calibration parse_opencv_or_ros(const YamlFields& root);

/// Lines of "KEY: number number ..." as KITTI writes them.
bool looks_like_kitti(std::string_view text);
Calibration parse_kitti(std::string_view text, std::string_view where);

/// Sets the distortion from its coefficients and the model's name as any of the formats writes it; throws for models
/// that Camera does not have. `where` and `key` name the coefficients in messages.
void set_distortion(Camera& camera, std::string_view model, std::span<const double> coefficients,
                    const std::string& where, std::string_view key);

/// Converts a size that was read as numbers; throws unless both are whole.
void set_size(Camera& camera, double width, double height, const std::string& where);
/// The key "intrinsics" of EuRoC and Kalibr: fx, fy, cx, cy.
void set_intrinsics(Camera& camera, const YamlFields& fields);
/// The key "rate_hz", if present; throws unless positive.
std::optional<double> optional_rate(const YamlFields& fields);

/// The key "calibration_error" of rastro's own, if present; throws unless it is a share.
std::optional<double> optional_calibration_error(const YamlFields& fields);

/// The key "readout_time" of rastro's own, seconds of a rolling shutter, if present; throws unless 0 to 1.
void set_readout_time(Camera& camera, const YamlFields& fields);

/// The keys "depth_camera" and "color_from_depth" of rastro's own, where the first is present.
std::optional<DepthRegistration> optional_depth_registration(const YamlFields& root,
                                                             std::vector<std::string>& warnings);

/// Throws unless focal lengths are positive and all values are of a plausible order.
void require_usable(const Camera& camera, const std::string& where);

/// A 3x4 or 4x4 rigid transform; throws if it is not rigid at all, warns if it is not quite.
SE3 rigid_transform(const Eigen::MatrixXd& matrix, std::string_view key, const std::string& where,
                    std::vector<std::string>& warnings);

/// A warning if the second camera of a pair, with the same viewing direction as the first, is to its left.
void check_baseline(const SE3& second_from_first, std::string_view first, std::string_view second,
                    std::vector<std::string>& warnings);

}  // namespace rastro::calibration
