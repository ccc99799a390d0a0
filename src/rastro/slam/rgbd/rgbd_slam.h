// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/camera/camera.h"
#include "rastro/slam/rgbd/options.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// RGB-D SLAM after Endres et al. 2012 and 2014: a depth camera is followed frame by frame, some frames are kept and
/// compared with others kept before, and a graph says where all of them stand. The body is the camera, the world the
/// first camera, or that of the map given.
class RgbdSlam : public Slam {
 public:
  /// What `context` holds must outlive this. Error for a map without what this method needs of one.
  RgbdSlam(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context);
  ~RgbdSlam() override;
  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override;
  Trajectory trajectory() const override;
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;

 private:
  class State;
  RgbdSlamOptions options_;
  Camera camera_;
  SlamContext context_;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
