// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "rastro/map/features/feature_points.h"
#include "rastro/map/graph/map.h"

namespace rastro {

// A reconstruction as COLMAP's text files have it: poses are camera_from_world, pixel centers at halves.

/// A camera as COLMAP names it, pixel centers at halves.
struct ColmapModel {
  const char* name = "";
  int id = 0;  ///< In its binary files.
  std::vector<double> parameters;
};
ColmapModel colmap_model(const Camera& camera);

/// cameras.txt: a line for each camera of the map, with its distortion. Cameras that do not know their size get this
/// one.
std::string colmap_cameras(const std::vector<MapCamera>& cameras, int width = 0, int height = 0);
/// images.txt: pose and features of each keyframe, where the map has images of those with one; a feature's point is its
/// index in `points` + 1, or -1.
std::string colmap_images(const Map& map, const std::vector<FeaturePoint>& points, int submap = 0);
/// points3D.txt: colors are those of the first keyframe that shows a point. The map must have images.
std::string colmap_points(const Map& map, const std::vector<FeaturePoint>& points);

/// All three, and the images as they are packed in images/; returns how many. Makes the folder. The map must have
/// images. Error where something cannot be read or written.
std::size_t write_colmap(const Map& map, const std::filesystem::path& folder, int submap = 0);

}  // namespace rastro
