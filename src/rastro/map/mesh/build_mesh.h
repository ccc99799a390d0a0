// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "rastro/base/task_pool.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/graph/map.h"
#include "rastro/map/mesh/triangle_mesh.h"

namespace rastro {

struct MeshOptions {
  double voxel_m = 0.02;      ///< Side of the voxels, and roughly that of the triangles; > 0.
  double truncation_m = 0.0;  ///< Distance from a surface up to which distances are stored; 0: four voxels.
  double min_depth_m = 0.3, max_depth_m = 5.0;
  int submap = 0;     ///< As in CloudOptions.
  int min_views = 2;  ///< Voxels observed from fewer keyframes have no surface; 1 for a map with only one keyframe.
  /// Of 8 x 8 x 8 voxels; for a map that needs more, an Error asks for larger voxels.
  std::size_t max_blocks = 60'000;
};

/// The surfaces as one mesh with colors: signed distances to the observed surfaces, averaged with weights 1 /
/// sigma(z)^2 (Curless and Levoy 1996, "A volumetric method for building complex models from range images"), in blocks
/// near surfaces only (Niessner et al. 2013), and their zero crossing as a surface net (Gibson 1998). The same bytes
/// for any pool. Error where images cannot be read.
TriangleMesh build_mesh(const Map& map, const MeshOptions& options, TaskPool* pool = nullptr,
                        const MapProgress& progress = {});

}  // namespace rastro
