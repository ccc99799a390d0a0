// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include <utility>

#include "rastro/base/task_pool.h"
#include "rastro/synthetic/frame_selection.h"
#include "rastro/synthetic/world.h"

namespace rastro {

/// Depth images of a depth camera with structured light.
struct DepthModel {
  double units_per_meter = 5000.0;           ///< As in the TUM benchmark.
  double nearest_m = 0.4, farthest_m = 8.0;  ///< Outside this range: 0.
  double sigma_m = 0.0012;                   ///< Noise up to 0.4 m, and its growth from there with the square of the
  double sigma_per_square_meter = 0.0019;    ///< distance (Nguyen, Izadi and Lovell 2012, axial part).
};

struct TumOptions {
  std::int64_t frames = 150;
  DepthModel depth = {};
  bool force = false;  ///< Write to a folder that is not empty, in place of such a recording there.
  /// The camera is covered from the first of these times to the second (seconds from the start): its images are black
  /// and without depth.
  std::optional<std::pair<double, double>> black = {};
  FrameSelection selection = {};  ///< Which frames; their stamps are those of the world.
};

struct TumSummary {
  std::int64_t frames = 0;
  std::uintmax_t bytes = 0;
};

/// Writes a generated world in the layout of the TUM RGB-D benchmark: rgb/ (in color if the world is), depth/ (16
/// bits), rgb.txt, depth.txt, groundtruth.txt (of the camera at the stamps of rgb.txt), camera.yaml and info.txt (the
/// depth factor). A world with a Kinect uses its model and not options.depth; depth.txt then has its own stamps. A
/// world with lengths also gets objects.yaml and truth.ply (write_objects.h). Frames are rendered and written in
/// parallel; the bytes are the same for any pool. `progress` is called with the number of frames written so far. Throws
/// Error for folders that cannot be written or are not empty.
TumSummary write_tum(const World& world, const std::filesystem::path& folder, const TumOptions& options, TaskPool& pool,
                     const std::function<void(std::int64_t)>& progress = {});

}  // namespace rastro
