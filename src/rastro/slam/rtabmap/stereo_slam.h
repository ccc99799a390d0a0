// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "rastro/feature/stereo_depth.h"
#include "rastro/sensor/stereo_pair.h"
#include "rastro/slam/slam.h"

namespace rastro {

/// Disparities that give a depth, pixels.
struct StereoRange {
  double least = 3.0;
  int most = 96;
};

/// SLAM of a depth camera for a stereo pair: each pair is rectified and gets a depth image. The body is the rectified
/// left camera.
class StereoSlam : public Slam {
 public:
  StereoSlam(const StereoPair& pair, const StereoRange& range, TaskPool* pool, std::unique_ptr<Slam> slam);
  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override { return slam_->finish(); }
  Trajectory trajectory() const override { return slam_->trajectory(); }
  std::shared_ptr<const Map> snapshot() const override { return slam_->snapshot(); }
  std::vector<PlaceBelief> places() const override { return slam_->places(); }
  void reset() override { slam_->reset(); }
  bool set_mapping(bool on) override { return slam_->set_mapping(on); }
  std::vector<FeatureObservation> observations() const override { return slam_->observations(); }
  std::int64_t dropped_frames() const override { return slam_->dropped_frames(); }
  MapMemory map_memory() const override { return slam_->map_memory(); }

 private:
  Frame with_depth(const Frame& recorded) const;

  std::optional<FrameRectifier> rectifier_;
  StereoDepth depth_;
  std::unique_ptr<Slam> slam_;
};

}  // namespace rastro
