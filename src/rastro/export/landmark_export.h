// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "rastro/export/g2o_text.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// Whether a map has what these are made from: features, and landmarks that keyframes observe (not those of a filter).
bool has_observed_landmarks(const Map& map);

// Landmarks with observations for other programs. `submap`: which part of the map; -1: all of them, each in its own
// frame.

/// id x y z sigma (along the mean viewing direction; empty: unknown) seen (how often), and the first keyframe that
/// observes it: frame, x_px, y_px. Lengths are in the map's unit. For 'rastro scale --length'.
std::string landmark_list_csv(const Map& map, int submap);

/// The essential graph as g2o reads it: VERTEX_SE3:QUAT numbered by keyframe ids (world_from_camera), EDGE_SE3:QUAT
/// with information in squared pixels as the landmarks that two keyframes share measure it (the pose of the second one
/// from its pixels, where landmarks lie as seen from the first one), or as loop closing found it for loop closures and
/// merges. With fewer than ten landmarks shared an edge follows the map, with little weight and a comment before it.
/// The first keyframe of each submap is fixed. `size`: what was written; may be null.
std::string landmark_graph_g2o(const Map& map, int submap, GraphSize* size = nullptr);

enum class ColmapForm { text, binary };

/// File names of the images of keyframes.
using ColmapNames = std::map<KeyframeId, std::string>;

/// What was written.
struct ColmapSize {
  std::size_t images = 0, points = 0;
};

/// cameras, images and points3D with observations and tracks, as COLMAP has them. Landmarks that fewer than two of the
/// keyframes observe are omitted. Keyframes without a name are named by frame numbers (000123.png), in a map of
/// several sessions by their ids as well (keyframe7_000123.png). Ids are those of the map plus 1. Makes the folder.
/// Error where something cannot be written.
ColmapSize write_landmark_colmap(const Map& map, const std::filesystem::path& folder, ColmapForm form, int submap,
                                 const ColmapNames& names = {});

}  // namespace rastro
