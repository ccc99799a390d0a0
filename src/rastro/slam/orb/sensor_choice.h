// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/base/task_pool.h"
#include "rastro/feature/orb.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/source.h"
#include "rastro/slam/orb/feature_frame.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// What a run works with.
struct SensorChoice {
  LandmarkSensor sensor = LandmarkSensor::mono;
  Camera camera;
  double baseline = 0.0;  ///< Metres; that of a made-up right camera where depth is seen.
};

/// With what depends on the pictures, and on a map given (may be null), filled in. Error for options out of range.
OrbSlamOptions options_for(OrbSlamOptions options, const SourceInfo& source, const LandmarkMap* map);
OrbOptions orb_options(const OrbSlamOptions& options);
/// All that the source has, or what `sensor` names; Error where the source lacks that.
SensorChoice choose_sensor(const OrbSlamOptions& options, const SourceInfo& source);

/// Error where a run cannot use the map: one camera finds its way in any, but goes on only with its own kind.
void check_map(const LandmarkMap& map, const SensorChoice& choice, bool extend);

/// Turns frames into features, with depth where it is seen.
class FeatureMaker {
 public:
  FeatureMaker(const OrbSlamOptions& options, const SensorChoice& sensor, TaskPool* pool);
  /// `depth_from_colour`: how the camera moves from the instant of the picture to that of its depth.
  std::shared_ptr<const FeatureFrame> make(const Frame& frame, const SE3& depth_from_colour);

 private:
  OrbSlamOptions options_;
  SensorChoice sensor_;
  TaskPool* pool_;
  OrbExtractor extractor_;
};

}  // namespace rastro
