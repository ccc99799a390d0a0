// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/features/options.h"
#include "rastro/odometry/ray_observations.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// Finds features frame by frame and gives all observations of one point the same id.
class FeatureSource {
 public:
  virtual ~FeatureSource() = default;
  /// Features with an undistorted ray. Frames come in the order of the recording.
  virtual RayObservations next(const Frame& frame) = 0;
};

/// The values of `matcher` in this build: tracks, sift, orb and, with dlib, surf.
std::vector<std::string> matcher_names();

/// Uses the occlusion-robust tracks, or descriptors matched between consecutive frames with ratio and mutual test.
/// Throws Error for an unknown matcher.
std::unique_ptr<FeatureSource> make_feature_source(const FeaturesOptions& options, const Camera& camera,
                                                   TaskPool* pool);

}  // namespace rastro
