// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/synthetic/frame_selection.h"
#include "rastro/synthetic/world.h"

namespace rastro {

enum class KittiLayout {
  odometry,  ///< image_0/000000.png, calib.txt, times.txt, poses.txt of the left camera, the first pose the origin.
  raw,       ///< DATE/DATE_drive_0001_sync/image_00/data, timestamps.txt, oxts/data, and DATE/calib_*.txt.
};

struct KittiOptions {
  std::int64_t frames = 400;
  KittiLayout layout = KittiLayout::odometry;
  bool force = false;             ///< Write to a folder that is not empty, in place of such a recording there.
  bool stereo = false;            ///< Also the right camera (odometry only). Throws Error for a world without one.
  FrameSelection selection = {};  ///< Which frames; their stamps are those of the world.
};

struct KittiSummary {
  std::int64_t frames = 0;
  std::uintmax_t bytes = 0;
  std::filesystem::path recording;  ///< The path to open: the folder itself, or the drive in it.
};

/// Writes a generated world as a KITTI recording (Geiger et al. 2012, 2013). Lens distortion is not part of the
/// formats: throws Error for a camera with distortion. In raw recordings the world's x axis points east and y north.
/// Frames are rendered and written in parallel; the bytes are the same for any pool. `progress` is called with the
/// number of frames written so far. Throws Error for folders that cannot be written or are not empty.
KittiSummary write_kitti(const World& world, const std::filesystem::path& folder, const KittiOptions& options,
                         TaskPool& pool, const std::function<void(std::int64_t)>& progress = {});

/// Measurement of the GPS/IMU unit (the world's body) in a frame: a line of 30 values as in KITTI raw's oxts/data, at
/// 49 degrees north, 8.4 east. Exact to 1e-6 m and 1e-9 rad.
std::string oxts_line(const World& world, std::int64_t frame);

}  // namespace rastro
