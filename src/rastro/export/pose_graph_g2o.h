// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/export/g2o_text.h"
#include "rastro/map/graph/map.h"

namespace rastro {

/// The keyframes and constraints of a submap (-1: of all) as g2o reads them: VERTEX_SE3:QUAT (x y z qx qy qz qw,
/// world_from_camera), numbered by keyframe ids, EDGE_SE3:QUAT with the upper triangle of the information of
/// (translation, vector part of the quaternion), which is half a rotation vector. The first keyframe of each submap is
/// fixed. Information is times the weight that the robust kernel left, so that the poses are a minimum of the file as
/// well; edges of weight 0 are comments. `size`: what was written, without comments; may be null.
std::string pose_graph_g2o(const Map& map, int submap = -1, GraphSize* size = nullptr);

}  // namespace rastro
