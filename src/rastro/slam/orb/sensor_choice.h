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
void check_map(const Map& map, const SensorChoice& choice, bool extend);

/// Rectifies the frames of a stereo pair.
class FrameRectifier {
 public:
  FrameRectifier(std::shared_ptr<const StereoRectification> rectification, TaskPool* pool);
  /// Rectifies images and mask; of the other fields copies only number, stamp and name. Error for an image that has not
  /// the calibration's size.
  Frame rectified(const Frame& frame) const;

 private:
  std::shared_ptr<const StereoRectification> rectification_;
  TaskPool* pool_;
  GrayImage shown_;  ///< Mask of the valid pixels of the left image.
};

/// How the camera moves while a frame is recorded, as predicted.
struct FrameMotion {
  SE3 depth_from_color;                                        ///< From the instant of the image to that of its depth.
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< As at_middle_row() takes it.
};

/// Extracts features from frames, where the camera had them when it read the middle row, with depth where it is
/// measured.
class FeatureMaker {
 public:
  FeatureMaker(const OrbSlamOptions& options, const SensorChoice& sensor, TaskPool* pool);
  std::shared_ptr<const FeatureFrame> make(const Frame& frame, const FrameMotion& motion = {});

 private:
  OrbSlamOptions options_;
  SensorChoice sensor_;
  TaskPool* pool_;
  OrbExtractor extractor_;
};

}  // namespace rastro
