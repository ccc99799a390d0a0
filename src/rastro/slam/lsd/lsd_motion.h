// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rastro/base/time.h"
#include "rastro/math/se3.h"

namespace rastro {

/// What is known of the camera's motion, as of the last frame with a pose.
struct LsdMotion {
  SE3 camera_from_keyframe, velocity;  ///< The camera's motion since the frame before, in the keyframe's unit.
  TimeNs stamp = 0, duration = 0;      ///< Of that frame; between both.
  int lost_frames = 0, weak_frames = 0;
  bool lost = false;

  /// Of the camera within `time`, at this velocity.
  SE3 within(TimeNs time) const {
    return duration > 0 ? SE3::exp(velocity.log() * (static_cast<double>(time) / static_cast<double>(duration)))
                        : SE3();
  }
  /// The frame at `at` has this pose. Across a loss no velocity is known.
  void accept(TimeNs at, const SE3& new_camera_from_keyframe) {
    velocity = lost ? SE3() : new_camera_from_keyframe * camera_from_keyframe.inverse();
    duration = lost ? 0 : at - stamp;
    camera_from_keyframe = new_camera_from_keyframe;
    stamp = at;
    lost = false;
    lost_frames = 0;
  }
  /// The last frame became the keyframe, whose unit is `unit` of the one before.
  void change_keyframe(double unit) {
    camera_from_keyframe = SE3();
    velocity = SE3(velocity.rotation(), velocity.translation() / unit);
  }
};

}  // namespace rastro
