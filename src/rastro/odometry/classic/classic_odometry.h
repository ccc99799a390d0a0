// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/odometry/classic/options.h"
#include "rastro/odometry/classic/three_view_chain.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/odometry/matched_features.h"
#include "rastro/odometry/odometry.h"

namespace rastro {

/// The classic odometry of METHODS 2.1 as the paper has it (D. Mendieta and M. Moreyra, "Posicionamiento basado en una
/// secuencia de imagenes"): descriptors matched from frame to frame, three frames at a time, no map and no adjustment.
/// Lengths are up to scale: the first motion has length 1.
class ClassicOdometry : public Odometry {
 public:
  /// Throws Error for settings out of range, and for SURF in a build without it. The pool must outlive the odometry;
  /// results do not depend on it.
  ClassicOdometry(const ClassicOptions& options, const Camera& camera, TaskPool* pool = nullptr);

  OdometryUpdate process(const Frame& frame) override;
  Trajectory trajectory() const override { return chain_.trajectory(); }
  std::vector<OdometryFeature> features() const override;

 private:
  ClassicOptions options_;
  Camera camera_;
  FrameCheck check_;
  MatchedFeatures matched_;
  ThreeViewChain chain_;
  RayObservations seen_;         ///< Of the last frame.
  std::int64_t newest_id_ = -1;  ///< Of the frames before it.
};

}  // namespace rastro
