// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rastro/map/keyframe/rgbd_map.h"

namespace rastro {

/// The keyframes and what ties them together as g2o reads it: VERTEX_SE3:QUAT (x y z qx qy qz qw, world_from_camera),
/// EDGE_SE3:QUAT with the upper triangle of the information of (translation, vector part of the quaternion), which is
/// half a rotation vector. The first keyframe of each submap is fixed. Information is times the weight that the robust
/// kernel left, so that the poses are a minimum of the file as well; edges of weight 0 are comments.
std::string pose_graph_g2o(const RgbdMap& map);

}  // namespace rastro
