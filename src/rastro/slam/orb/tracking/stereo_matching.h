// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/base/task_pool.h"
#include "rastro/feature/orb.h"
#include "rastro/image/image.h"
#include "rastro/map/features/feature_layer.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// Fills right_x and depths of the left camera's features from a rectified pair (corresponding points are in the same
/// row): the most similar feature near the same row of the right image, then the shift with the smallest intensity
/// difference, to subpixel precision (Mur-Artal and Tardos 2017, section III.A). `focal_baseline`: focal length in
/// pixels times baseline. `pool` may be null; the result is the same with any.
void match_stereo(GrayView left, GrayView right, const Features& right_features, double focal_baseline,
                  const OrbSlamOptions& options, TaskPool* pool, ImageFeatures& keyframe);

}  // namespace rastro
