// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rastro/map/keyframe/feature_points.h"
#include "rastro/map/keyframe/rgbd_map.h"

namespace rastro {

// A reconstruction as COLMAP's text files have it: poses are camera_from_world, pixel centres at halves.

/// A camera as COLMAP names it, pixel centres at halves.
struct ColmapModel {
  const char* name = "";
  int id = 0;  ///< In its binary files.
  std::vector<double> parameters;
};
ColmapModel colmap_model(const Camera& camera);

/// cameras.txt: the one camera with its distortion, for pictures of this size.
std::string colmap_cameras(const Camera& camera, int width, int height);
/// images.txt: pose and features of each keyframe; a feature's point is its place in `points` + 1, or -1.
std::string colmap_images(const RgbdMap& map, const std::vector<FeaturePoint>& points, int submap = 0);
/// points3D.txt: colours are those of the first keyframe that shows a point.
std::string colmap_points(const RgbdMap& map, const std::vector<FeaturePoint>& points);

/// All three, and the pictures as they are packed in images/. Makes the folder. Error where something cannot be read
/// or written.
void write_colmap(const RgbdMap& map, const std::filesystem::path& folder, int submap = 0);

}  // namespace rastro
