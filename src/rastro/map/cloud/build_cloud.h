// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "rastro/base/task_pool.h"
#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/graph/map.h"

namespace rastro {

struct CloudOptions {
  double voxel_m = 0.01;  ///< One point a voxel; > 0.
  int stride = 2;         ///< Every so many-th pixel of every so many-th row, >= 1.
  double min_depth_m = 0.3, max_depth_m = 5.0;
  double grazing_deg = 80.0;  ///< Surfaces seen flatter than this between ray and normal are left out.
  int submap = 0;             ///< Keyframes of this submap; -1: of all, each in the frame of its own.
  int min_count = 3;          ///< Points of fewer measurements are left out.
  int min_views = 1;          ///< And those seen from fewer keyframes.
  /// Where a map needs more voxels, their side is doubled; PointCloud::voxel_m says what came of it. Each takes about
  /// 100 bytes of memory.
  std::size_t max_voxels = 4'000'000;
};

/// Told how many of how many keyframes are done.
using MapProgress = std::function<void(std::size_t done, std::size_t all)>;

/// The surfaces that the keyframes saw, from their depth pictures put where the keyframes stand. Measurements weigh
/// 1 / sigma(z)^2; layers that noise spreads over several voxels along the normal are brought together in one, and
/// points whose measurements contradict each other are left out. The sigma of a point counts the measurements of one
/// keyframe in a voxel as one, since their noise is not independent, and grows where they scatter more than the noise
/// model says. The same bytes for any pool. Error where pictures cannot be read.
PointCloud build_cloud(const Map& map, const CloudOptions& options, TaskPool* pool = nullptr,
                       const MapProgress& progress = {});

}  // namespace rastro
