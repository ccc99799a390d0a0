// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/map/cloud/point_cloud.h"
#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

// A map of landmarks for other programs. `submap`: which part of it; -1: all of them, each in its own frame.

/// One grey point a landmark: the normal looks to where it was seen from, `count` is how often it was seen, `sigma`
/// that of its place along the normal (0 where not known).
PointCloud landmark_cloud(const LandmarkMap& map, int submap);

/// id x y z sigma seen, and the first keyframe that shows it: frame, x_px, y_px. For 'rastro scale --length'.
std::string landmark_list_csv(const LandmarkMap& map, int submap);

/// The essential graph as g2o reads it: VERTEX_SE3:QUAT numbered by keyframe ids (world_from_camera), EDGE_SE3:QUAT
/// with the poses as they stand, or as loop closing found them for ties. Information is the identity times a hundredth
/// of the landmarks shared. The first keyframe of each submap is fixed.
std::string landmark_graph_g2o(const LandmarkMap& map, int submap);

enum class ColmapForm { text, binary };

/// cameras, images and points3D with observations and tracks, as COLMAP has them; images are named by frame numbers
/// (000123.png), as a map of landmarks holds no pictures. Ids are those of the map plus 1. Makes the folder. Error
/// where something cannot be written.
void write_landmark_colmap(const LandmarkMap& map, const std::filesystem::path& folder, ColmapForm form, int submap);

}  // namespace rastro
