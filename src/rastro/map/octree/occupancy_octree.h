// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// The defaults are those of Hornung et al. 2013, "OctoMap".
struct OctreeOptions {
  double resolution_m = 0.05;  ///< Side of the smallest cubes, > 0.
  int stride = 4;              ///< Every stride-th pixel of every stride-th row, >= 1.
  double min_depth_m = 0.3;
  double max_range_m = 5.0;                 ///< For surfaces farther away along a ray, the space up to here is free.
  double hit = 0.7, miss = 0.4;             ///< Occupancy probability from a single measurement.
  double lowest = 0.1192, highest = 0.971;  ///< Occupancy is clamped to this range, so that it can change again.
  int submap = 0;                           ///< As in CloudOptions.
};

/// A cube of space; eight alike are one larger cube.
struct OctreeCube {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< World, meters.
  double side_m = 0.0;
};

/// The occupancy probability of each cube of space, as an OctoMap. World as in the map, meters.
class OccupancyOctree {
 public:
  struct Tree;  ///< Of OctoMap.
  explicit OccupancyOctree(std::unique_ptr<Tree> tree);
  OccupancyOctree(OccupancyOctree&& other) noexcept;
  OccupancyOctree& operator=(OccupancyOctree&& other) noexcept;
  ~OccupancyOctree();

  double resolution_m() const;
  /// Probability 0..1 of the cube at a position; nullopt where unknown.
  std::optional<double> occupancy_at(const Eigen::Vector3d& position) const;
  /// Bounds of the known space; both zero for an empty tree.
  Eigen::Vector3d low() const;
  Eigen::Vector3d high() const;
  std::size_t occupied_leaves() const;
  std::size_t free_leaves() const;
  /// In the order of the tree.
  std::vector<OctreeCube> occupied_cubes() const;

  /// The file formats of OctoMap: .ot holds probabilities, .bt occupied or free only.
  std::string ot_bytes() const;
  std::string bt_bytes() const;

 private:
  std::unique_ptr<Tree> tree_;
};

/// Each depth image updates each cube once: hit if a ray ends in it, free if rays only pass through it. Keyframes are
/// inserted in order; the same bytes for any pool. Error where images cannot be read.
OccupancyOctree build_octree(const Map& map, const OctreeOptions& options, TaskPool* pool = nullptr,
                             const MapProgress& progress = {});

}  // namespace rastro
