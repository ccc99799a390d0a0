// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/feature/orb.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/source.h"
#include "rastro/sensor/stereo_pair.h"
#include "rastro/slam/orb/map/feature_frame.h"
#include "rastro/slam/orb/options.h"
#include "rastro/slam/orb/tracking/frame_rotation.h"

namespace rastro {

/// The sensor data that a run uses.
struct SensorChoice {
  CameraKind sensor = CameraKind::mono;
  Camera camera;
  double baseline = 0.0;  ///< Meters; virtual for a depth camera.
  /// For an unrectified stereo pair; null: images are used as they are. With it, camera and baseline are those of the
  /// rectified pair.
  std::shared_ptr<const StereoRectification> rectification;

  SE3 camera_from_left() const;  ///< From the recording's (left) camera frame; identity where not rectified.
};

/// Fills in what depends on the images, and on a given map (may be null). Error for options out of range.
OrbSlamOptions options_for(OrbSlamOptions options, const SourceInfo& source, const Map* map);
OrbOptions orb_options(const OrbSlamOptions& options);
/// All sensors of the source, or the one named in `sensor`; Error where the source lacks it.
SensorChoice choose_sensor(const OrbSlamOptions& options, const SourceInfo& source);

/// Error where a run cannot use the map: one camera can localize in any map, but continues only a map of its own kind.
/// `method`: that of the run.
void check_map(const Map& map, const SensorChoice& choice, bool extend, const std::string& method = "orb");

/// Extracts features from frames, with depth where it is measured. Those of a rolling shutter are moved to where the
/// camera had them when it read the middle row.
class FeatureMaker {
 public:
  FeatureMaker(const OrbSlamOptions& options, const SensorChoice& sensor, TaskPool* pool);
  /// Of the following frames, instead of options.features.
  void set_features(int features) { extractor_.set_features(features); }
  /// `depth_from_color`: motion of the camera from the instant of the image to that of its depth.
  std::shared_ptr<const FeatureFrame> make(const Frame& frame, const SE3& depth_from_color = {});
  /// False: the features of the last frame are as recorded, since the rotation of a rolling shutter is unknown.
  bool is_rotation_known() const { return !shutter_ || angular_velocity_; }
  /// A frame that was made while it was unknown, with the rotation known since.
  std::shared_ptr<const FeatureFrame> with_rotation(const FeatureFrame& frame) const;

 private:
  std::shared_ptr<const FeatureFrame> at_middle_row(ImageFeatures features) const;

  OrbSlamOptions options_;
  SensorChoice sensor_;
  TaskPool* pool_;
  OrbExtractor extractor_;
  std::optional<FrameRotation> shutter_;             ///< Of a rolling shutter.
  std::optional<Eigen::Vector3d> angular_velocity_;  ///< In the last frame.
};

}  // namespace rastro
