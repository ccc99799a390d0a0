// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "rastro/base/task_pool.h"
#include "rastro/camera/stereo_rectification.h"
#include "rastro/feature/orb.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/source.h"
#include "rastro/slam/orb/map/feature_frame.h"
#include "rastro/slam/orb/options.h"

namespace rastro {

/// What a run works with.
struct SensorChoice {
  CameraKind sensor = CameraKind::mono;
  Camera camera;
  double baseline = 0.0;  ///< Metres; that of a made-up right camera where depth is seen.
  /// Of a pair whose rows do not show the same; null: pictures are used as they are. Camera and baseline are those of
  /// the rectified pair then.
  std::shared_ptr<const StereoRectification> rectification;

  SE3 camera_from_left() const;  ///< From what the recording has for its (left) camera; no turn where not rectified.
};

/// With what depends on the pictures, and on a map given (may be null), filled in. Error for options out of range.
OrbSlamOptions options_for(OrbSlamOptions options, const SourceInfo& source, const Map* map);
OrbOptions orb_options(const OrbSlamOptions& options);
/// All that the source has, or what `sensor` names; Error where the source lacks that.
SensorChoice choose_sensor(const OrbSlamOptions& options, const SourceInfo& source);

/// Error where a run cannot use the map: one camera finds its way in any, but goes on only with its own kind.
void check_map(const Map& map, const SensorChoice& choice, bool extend);

/// Frames as a rectified pair has them.
class FrameRectifier {
 public:
  FrameRectifier(std::shared_ptr<const StereoRectification> rectification, TaskPool* pool);
  /// Pictures and mask; besides them only number, stamp and name. A picture of another size than the calibration's:
  /// Error.
  Frame rectified(const Frame& frame) const;

 private:
  std::shared_ptr<const StereoRectification> rectification_;
  TaskPool* pool_;
  GreyImage shown_;  ///< Mask of what the left picture shows.
};

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
