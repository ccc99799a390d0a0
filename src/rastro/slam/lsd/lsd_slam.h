// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "rastro/slam/lsd/lsd_sensor.h"
#include "rastro/slam/lsd/options.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// Direct semi-dense SLAM, METHODS 7: J. Engel, J. Sturm and D. Cremers, "Semi-Dense Visual Odometry for a Monocular
/// Camera", 2013; J. Engel, T. Schoeps and D. Cremers, "LSD-SLAM: Large-Scale Direct Monocular SLAM", 2014; J. Engel,
/// J. Stueckler and D. Cremers, "Large-Scale Direct SLAM with Stereo Cameras", 2015. The body is the (left) camera; the
/// world is the first keyframe's camera. Its unit is the meter with a pair or a depth camera, else the harmonic mean of
/// the depths there.
class LsdSlam : public Slam {
 public:
  LsdSlam(const LsdOptions& options, const LsdSensor& sensor, const SlamContext& context);
  ~LsdSlam() override;
  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override;
  Trajectory trajectory() const override;
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;
  MapMemory map_memory() const override;
  std::int64_t dropped_frames() const override;

 private:
  class State;
  LsdOptions options_;
  LsdSensor sensor_;
  SlamContext context_;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
