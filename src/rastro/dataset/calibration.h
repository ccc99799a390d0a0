// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rastro/dataset/image_file.h"
#include "rastro/dataset/open.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// Whether the caller gives the calibration, so that none needs to be looked for (and a broken one does no harm).
bool calibration_is_given(const OpenOptions& options);

/// A camera without calibration.
CalibratedCamera uncalibrated(const std::string& name);

/// Reads the cameras called `names` from a file of any kind that camera/calibration_file.h knows. A file with one
/// camera serves any single name; otherwise a name that is not there stays uncalibrated. Sets info.left_from_right
/// where the file tells it for the first two names. Error where the file cannot be read or holds none of the names.
void read_cameras(SourceInfo& info, const std::filesystem::path& file, const std::vector<std::string>& names);

/// Reads the camera of images that belong to none by name (a folder, a video): the one that is `wanted`, else the only
/// one, else the first with a warning that names all. It is called `own_name` where the file has only one. Error where
/// there is no such camera.
void read_unnamed_camera(SourceInfo& info, const std::filesystem::path& file, const std::string& own_name,
                         const std::string& wanted);

/// first_from_camera of camera `name`, where the file chains its cameras (KITTI, Kalibr); nullopt otherwise.
std::optional<SE3> first_from_camera(const std::filesystem::path& file, const std::string& name);

/// A calibration file in `folder` under one of the usual names (camera.yaml, calibration.yaml, camera_info.yaml,
/// camchain.yaml, sensor.yaml, calib.txt); empty where there is none. One that has a depth factor but no camera is not
/// it.
std::filesystem::path find_calibration_file(const std::filesystem::path& folder);

/// left_from_right of two cameras whose poses on the body are known; nullopt otherwise.
std::optional<SE3> relative_pose(const CalibratedCamera& left, const CalibratedCamera& right);

/// Puts the given calibration (--calibration, --intrinsics, --fov) in place of what was found (or, for --fov, where
/// none was), fills in the image size, and adds a warning for each thing that looks wrong or is missing. A given file
/// with none of the names of a pair serves it in its own order.
void finish_calibration(SourceInfo& info, const OpenOptions& options, std::optional<ImageSize> size);

}  // namespace rastro
