// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/graph/map.h"
#include "rastro/viewer/scene.h"

namespace rastro {

struct ViewSceneOptions {
  int submap = 0;                      ///< As in CloudOptions: -1 is all, each in the frame of its own.
  std::size_t max_points = 300'000;    ///< Of each layer of points, at least 1; others are thinned evenly.
  std::size_t max_ellipsoids = 1'000;  ///< Of landmarks, evenly chosen.
  std::size_t max_images = 0;          ///< Small images of keyframes, evenly chosen.
  int covisible = 30;                  ///< Landmarks that an edge of the covisibility graph shares at least.
  bool mesh = false;                   ///< Of a map with depth images; takes seconds to minutes.
  bool octree = false;                 ///< As mesh.
};

/// What the page shows of a map: keyframes with their graphs, the frames that it holds, and every layer that has
/// something to see: landmarks, points of other layers, the cloud of depth images, the occupancy grid of scans.
/// The same scene for any pool. Error where images cannot be read.
ViewScene build_scene(const Map& map, const ViewSceneOptions& options, TaskPool& pool,
                      const MapProgress& progress = {});

/// A cloud as a layer: at most `most` of its points, evenly spread; colors and sigmas where it has some.
ScenePoints scene_points(PointCloud cloud, std::string name, std::size_t most);

}  // namespace rastro
