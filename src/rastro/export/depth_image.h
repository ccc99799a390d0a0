// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>

#include "rastro/base/task_pool.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// One JPEG per keyframe with semi-dense depth, ID.jpg: on the left its pixels with gradient, on the right their
/// inverse depths from blue (far) over green to red (near), as in Engel et al. 2014; below how many there are and how
/// certain they are. strip.png has up to twelve of the latter in a row of rows, in the order of the run. The bytes do
/// not depend on the pool. Returns the number of keyframes. Error where the map has no semi-dense depth, or the folder
/// or a file cannot be written.
std::size_t write_depth_images(const Map& map, const std::filesystem::path& folder, TaskPool& pool,
                               const std::function<void(std::size_t done, std::size_t all)>& progress = {});

/// The same as a video in real time, .mp4 or .avi: at each instant the newest keyframe. Returns the number of
/// keyframes. Error as above, for another extension, and where rastro was built without video.
std::size_t write_depth_video(const Map& map, const std::filesystem::path& file,
                              const std::function<void(std::size_t done, std::size_t all)>& progress = {});

}  // namespace rastro
