// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "rastro/map/graph/map.h"

namespace rastro {

/// Whether a map has what these are made from: features, and landmarks that keyframes observe (not those of a filter).
bool has_observed_landmarks(const Map& map);

// Landmarks with observations for other programs. `submap`: which part of the map; -1: all of them, each in its own
// frame.

/// id x y z sigma seen (how often), and the first keyframe that observes it: frame, x_px, y_px. For 'rastro scale
/// --length'.
std::string landmark_list_csv(const Map& map, int submap);

/// The essential graph as g2o reads it: VERTEX_SE3:QUAT numbered by keyframe ids (world_from_camera), EDGE_SE3:QUAT
/// between the poses as they are, or as loop closing found it for loop closures and merges. Information is the identity
/// times a hundredth of the landmarks shared. The first keyframe of each submap is fixed.
std::string landmark_graph_g2o(const Map& map, int submap);

enum class ColmapForm { text, binary };

/// cameras, images and points3D with observations and tracks, as COLMAP has them; images are named by frame numbers
/// (000123.png), as the images need not be in the map. Ids are those of the map plus 1. Makes the folder. Error
/// where something cannot be written.
void write_landmark_colmap(const Map& map, const std::filesystem::path& folder, ColmapForm form, int submap);

}  // namespace rastro
