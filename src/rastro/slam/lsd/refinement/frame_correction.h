// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/slam/lsd/semi_dense_graph.h"

namespace rastro {

/// The graph's frames with their poses relative to their keyframes as the corrected keyframes have them. A frame that
/// became a keyframe was placed by its alignment with the one before; where the map has moved the one against the other
/// since, it gets the pose of the keyframe that it became, the frames between both get a share of the difference that
/// grows from frame to frame, and the frames still aligned with the old one after it get all of it. Poses of keyframes
/// are not changed. Frames after the last keyframe, and before a return to an earlier one, stay as they are.
std::vector<PlacedFrame> frames_between_corrected_keyframes(const SemiDenseGraph& graph);

}  // namespace rastro
