// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// Direct semi-dense SLAM of one camera, METHODS 7: J. Engel, J. Sturm and D. Cremers, "Semi-Dense Visual Odometry for
/// a Monocular Camera", 2013; J. Engel, T. Schoeps and D. Cremers, "LSD-SLAM: Large-Scale Direct Monocular SLAM", 2014.
/// The body is the camera; the world is the first keyframe's camera, and its unit the harmonic mean of the depths
/// there.
class LsdSlam : public Slam {
 public:
  LsdSlam(const LsdOptions& options, const Camera& camera, const SlamContext& context);
  ~LsdSlam() override;
  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override;
  Trajectory trajectory() const override;
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;
  MapMemory map_memory() const override;

 private:
  class State;
  LsdOptions options_;
  Camera camera_;
  SlamContext context_;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
