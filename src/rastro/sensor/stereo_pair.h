// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "rastro/base/task_pool.h"
#include "rastro/camera/stereo_rectification.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// Two cameras side by side, with corresponding points in the same row of both images.
struct StereoPair {
  Camera camera;          ///< Of both images.
  double baseline = 0.0;  ///< Meters.
  /// How the recorded images become such a pair; null: they are one.
  std::shared_ptr<const StereoRectification> rectification;

  SE3 camera_from_left() const;  ///< From the recording's left camera frame; identity where not rectified.
};

/// Whether both cameras of a source are calibrated, with their baseline.
bool has_calibrated_pair(const SourceInfo& source);
/// Rectified where it has to be; nullopt without calibration, or for cameras that are not side by side.
std::optional<StereoPair> stereo_pair(const SourceInfo& source);
/// As stereo_pair; where there is none, Error if `is_required`, else a warning that only the left camera is used.
std::optional<StereoPair> choose_stereo_pair(const SourceInfo& source, bool is_required);

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

}  // namespace rastro
