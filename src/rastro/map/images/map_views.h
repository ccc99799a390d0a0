// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/map/graph/map.h"
#include "rastro/map/images/depth_surface.h"

namespace rastro::detail {

/// Calls body(i) for i in [0, count), on the pool where there is one.
void for_each_index(TaskPool* pool, std::size_t count, const std::function<void(std::size_t)>& body);

/// The keyframes of a submap (-1: of all) that have a finite pose and, where the map has any images, images; in order.
std::vector<std::size_t> keyframes_of(const Map& map, int submap);

SurfaceOptions surface_options(const Map& map, int stride, double min_depth_m, double max_depth_m);

/// Iterates over keyframes a few at a time, so that memory does not grow with the map: `prepare` is called for each on
/// any thread with its images, then `merge` for each group in order. `prepare` writes to the entry `slot` of its group.
class MapViews {
 public:
  static constexpr std::size_t group_size = 8;  ///< Unless fewer are asked for.
  using Prepare = std::function<void(std::size_t slot, std::size_t keyframe, const UnpackedImages&, const RayTable&)>;
  using Merge = std::function<void(std::size_t first, std::size_t count)>;  ///< Of the list of keyframes.

  MapViews(const Map& map, std::vector<std::size_t> keyframes, TaskPool* pool, std::size_t at_once = group_size);
  const std::vector<std::size_t>& keyframes() const { return keyframes_; }
  /// Error where images cannot be read or have different sizes.
  void walk(const Prepare& prepare, const Merge& merge, const std::function<void(std::size_t, std::size_t)>& progress);

 private:
  UnpackedImages packed_images_of(std::size_t keyframe) const;
  const Map& map_;
  std::shared_ptr<const ImageStore> images_;
  std::vector<std::size_t> keyframes_;
  TaskPool* pool_;
  std::size_t at_once_;
  RayTable rays_;
};

}  // namespace rastro::detail
