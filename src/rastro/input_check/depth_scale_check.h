// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>
#include <vector>

#include "rastro/camera/camera.h"
#include "rastro/input_check/input_warning.h"
#include "rastro/input_check/sample_schedule.h"
#include "rastro/sensor/frame.h"

namespace rastro {

/// The steps of the depth against those of a camera that projects a pattern (Kinect, Xtion, Carmine): its disparities
/// have steps of 1/8 px, so those of the depth z are k z^2 with k = 1/8 px / (f b) (Khoshelham and Elberink 2012,
/// section 3.1). A depth with another factor has another k. Says nothing of cameras with other proportions, nor of
/// depth without such steps.
class DepthScaleCheck {
 public:
  explicit DepthScaleCheck(const std::optional<Camera>& camera);

  void add(const Frame& frame, InputWarnings& found);

 private:
  std::optional<double> expected_;  ///< k, 1/m.
  SampleSchedule schedule_;
  std::int64_t number_ = 0;
  bool said_ = false;
  std::vector<double> measured_;  ///< k of the images with steps.
};

/// k of a depth image, 1/m; nullopt where its depths have no steps that grow with their square.
std::optional<double> depth_steps(const DepthImage& depth);

}  // namespace rastro
