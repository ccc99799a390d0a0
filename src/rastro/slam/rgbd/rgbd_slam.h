// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/slam/rgbd/options.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

class RgbdSession;

/// RGB-D SLAM after Endres et al. 2012 and 2014: tracks a depth camera frame by frame, compares keyframes with earlier
/// ones and optimizes their pose graph. The body is the camera; the world is the first camera, or that of the given
/// map.
class RgbdSlam : public Slam {
 public:
  /// Everything in `context` must outlive this. Error for a map that lacks what this method needs.
  RgbdSlam(const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context);
  ~RgbdSlam() override;
  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override;
  Trajectory trajectory() const override;
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;
  /// Not with a given map, and off only once there is a map.
  bool set_mapping(bool on) override;
  std::vector<FeatureObservation> observations() const override;
  std::int64_t dropped_frames() const override;
  MapMemory map_memory() const override;

 private:
  RgbdSlamOptions options_;
  Camera camera_;
  SlamContext context_;
  std::unique_ptr<RgbdSession> session_;
};

}  // namespace rastro
