// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/map/features/feature_layer.h"

namespace rastro {

/// How the camera rotates from frame to frame, by their features alone, tracked or not: what the compensation of a
/// rolling shutter needs.
class FrameRotation {
 public:
  FrameRotation(const Camera& camera, std::uint64_t seed, TaskPool* pool);
  /// Angular velocity in rad/s since the last frame given, as at_middle_row() takes it. nullopt for the first one, and
  /// where too few features of both show one rotation. `frame` has the features as recorded.
  std::optional<Eigen::Vector3d> next(const std::shared_ptr<const ImageFeatures>& frame);

 private:
  Camera camera_;
  std::uint64_t seed_;
  TaskPool* pool_;
  std::shared_ptr<const ImageFeatures> last_;
};

}  // namespace rastro
