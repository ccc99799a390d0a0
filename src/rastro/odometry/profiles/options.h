// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/base/options.h"
#include "rastro/odometry/frame_check.h"
#include "rastro/registration/profiles/rotation_options.h"

namespace rastro {

/// Settings of the odometry from profiles alone.
struct ProfilesOptions {
  RotationOptions rotation;
  double forward_step = 1.0;
  int max_bridged_frames = 5;
  FrameCheckOptions check;
};

/// The table points into `options`, which must outlive it.
OptionTable option_table(ProfilesOptions& options);

}  // namespace rastro
