// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/features/local_map.h"
#include "rastro/odometry/features/options.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Finds features in frame after frame and gives those of one place one id.
class FeatureSource {
 public:
  virtual ~FeatureSource() = default;
  /// Features with an undistorted ray; frames in the order of the recording.
  virtual RaySightings next(const Frame& frame) = 0;
};

/// The names `matcher` may have in this build: tracks, sift, orb and, where dlib is in, surf.
std::vector<std::string> matcher_names();

/// By the occlusion-robust tracks, or by descriptors matched from one frame to the next with ratio and mutual test.
/// Error for an unknown matcher.
std::unique_ptr<FeatureSource> make_feature_source(const FeaturesOptions& options, const Camera& camera,
                                                   TaskPool* pool);

}  // namespace rastro
