// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rastro/sensor/source.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/session.h"
#include "rastro/slam/slam.h"
#include "rastro/slam/slam_method.h"

namespace rastro {

/// Keyframe SLAM, METHODS 6: R. Mur-Artal, J. M. M. Montiel and J. D. Tardos, "ORB-SLAM: a versatile and accurate
/// monocular SLAM system", 2015; R. Mur-Artal and J. D. Tardos, "ORB-SLAM2", 2017. The body is the (left) camera; the
/// world is the first keyframe's camera. The map is in meters with stereo or depth; with one camera its unit is
/// arbitrary: half of the first points are nearer than 1.
class OrbSlam : public Slam {
 public:
  /// `source` must have a calibrated camera. Error for options out of range, and where it lacks the sensor named in
  /// `sensor`.
  OrbSlam(const OrbSlamOptions& options, const SourceInfo& source, const SlamContext& context,
          const OrbMethodParts& parts = {});
  ~OrbSlam() override;
  SlamUpdate process(const Frame& frame) override;
  std::vector<SlamEvent> finish() override;
  Trajectory trajectory() const override;
  std::shared_ptr<const Map> snapshot() const override;
  void reset() override;
  /// Off only once there is a map.
  bool set_mapping(bool on) override;
  std::vector<FeatureObservation> observations() const override;
  std::int64_t dropped_frames() const override;
  MapMemory map_memory() const override;

 private:
  class State;
  OrbSlamOptions options_;
  SourceInfo source_;
  SlamContext context_;
  OrbMethodParts parts_;
  std::unique_ptr<State> state_;
};

}  // namespace rastro
