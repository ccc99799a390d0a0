// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rastro/backend/rgbd/options.h"
#include "rastro/camera/camera.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

class LoopSearch;
class RgbdSession;

/// SLAM with keyframes of a depth camera: tracks it frame by frame, compares keyframes with earlier ones and optimizes
/// their pose graph. Where loops are looked for makes the difference between Endres et al. 2012, 2014 and Labbe and
/// Michaud 2013, 2014. The body is the camera; the world is the first camera, or that of the given map.
class RgbdSlam : public Slam {
 public:
  using MakeSearch = std::function<std::unique_ptr<LoopSearch>()>;
  /// Everything in `context` must outlive this. Error for a map that lacks what this method needs. `method`: name in
  /// maps. Without `make_search`, a GraphSearch. `baseline`: in meters, where the depth is that of a stereo pair.
  RgbdSlam(const std::string& method, const RgbdSlamOptions& options, const Camera& camera, const SlamContext& context,
           MakeSearch make_search = {}, double baseline = 0.0);
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
  std::vector<PlaceBelief> places() const override;

 private:
  std::unique_ptr<RgbdSession> new_session() const;

  RgbdSlamOptions options_;
  Camera camera_;
  SlamContext context_;
  std::string method_;
  MakeSearch make_search_;
  double baseline_;
  std::unique_ptr<RgbdSession> session_;
};

}  // namespace rastro
