// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "rastro/dataset/recording.h"

namespace rastro {

/// KITTI odometry sequence (Geiger et al. 2012): image_0 [image_1 ...], times.txt, calib.txt, and poses.txt beside them
/// or
/// ../../poses/NN.txt as in the official layout. nullopt where `path` looks like nothing of the kind.
std::optional<Recording> index_kitti_odometry(const std::filesystem::path& path, const OpenOptions& options);

}  // namespace rastro
