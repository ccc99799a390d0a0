// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/map/cloud/build_cloud.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// The defaults are those of Hornung et al. 2013, "OctoMap".
struct OctreeOptions {
  double resolution_m = 0.05;  ///< Side of the smallest cubes, > 0.
  int stride = 4;              ///< Every so many-th pixel of every so many-th row, >= 1.
  double min_depth_m = 0.3;
  double max_range_m = 5.0;      ///< Surfaces farther away along a ray only say that the space up to here is free.
  double hit = 0.7, miss = 0.4;  ///< Occupancy that one measurement says by itself.
  double lowest = 0.1192, highest = 0.971;  ///< Occupancy is kept between them, so that it can change again.
  int submap = 0;                           ///< As in CloudOptions.
};

/// How likely each cube of space is occupied, as an OctoMap. World as in the map, metres.
class OccupancyOctree {
 public:
  struct Tree;  ///< Of OctoMap.
  explicit OccupancyOctree(std::unique_ptr<Tree> tree);
  OccupancyOctree(OccupancyOctree&& other) noexcept;
  OccupancyOctree& operator=(OccupancyOctree&& other) noexcept;
  ~OccupancyOctree();

  double resolution_m() const;
  /// Probability 0..1 of the cube at a place; nullopt where nothing is known.
  std::optional<double> occupancy_at(const Eigen::Vector3d& place) const;
  /// What is known lies between these corners; both zero for an empty tree.
  Eigen::Vector3d low() const;
  Eigen::Vector3d high() const;
  std::size_t occupied_leaves() const;
  std::size_t free_leaves() const;

  /// The file formats of OctoMap: .ot holds probabilities, .bt occupied or free only.
  std::string ot_bytes() const;
  std::string bt_bytes() const;

 private:
  std::unique_ptr<Tree> tree_;
};

/// Every depth picture says once of each cube whether a ray ends in it (it is hit) or only passes (it is free).
/// Keyframes count in order; the same bytes for any pool. Error where pictures cannot be read.
OccupancyOctree build_octree(const Map& map, const OctreeOptions& options, TaskPool* pool = nullptr,
                             const MapProgress& progress = {});

}  // namespace rastro
