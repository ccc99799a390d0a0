// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "rastro/dataset/open.h"

namespace rastro {

/// rastro's own landmark log. Small enough to be kept in memory whole.
std::unique_ptr<Source> open_landmark_log(const std::string& path, const OpenOptions& options);

/// One robot of UTIAS MRCLAM: a folder with RobotN_Odometry.dat, RobotN_Measurement.dat and Barcodes.dat (the first
/// robot), or one of a robot's files; RobotN_Groundtruth.dat is the ground truth where it is there. nullptr where
/// `path` is none.
std::unique_ptr<Source> open_mrclam(const std::string& path, const OpenOptions& options);

}  // namespace rastro
