// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "rastro/base/time.h"
#include "rastro/math/se3.h"
#include "rastro/math/sim3.h"

namespace rastro {

/// camera_from_new of a camera whose pose relative to the keyframe before is known. The scale of before_from_new is the
/// new keyframe's unit in that of the one before.
inline SE3 on_new_keyframe(const SE3& camera_from_before, const Sim3& before_from_new) {
  const Sim3 camera_from_new = Sim3(camera_from_before) * before_from_new;
  return {camera_from_new.rotation(), camera_from_new.translation() / before_from_new.scale()};
}

/// What is known of the camera's motion, as of the last frame with a pose.
struct LsdMotion {
  SE3 camera_from_keyframe, velocity;  ///< The camera's motion since the frame before, in the keyframe's unit.
  TimeNs stamp = 0, duration = 0;      ///< Of that frame; between both.
  int lost_frames = 0, weak_frames = 0;
  bool lost = false;
  SE3 map_moved;  ///< new_from_old of poses in the world, where the map was corrected under the camera.

  /// Of the camera within `time`, at this velocity.
  SE3 within(TimeNs time) const {
    return duration > 0 ? SE3::exp(velocity.log() * (static_cast<double>(time) / static_cast<double>(duration)))
                        : SE3();
  }
  /// How far such an acceleration takes the camera from this motion until then; infinite where no motion is known.
  double step_until(TimeNs at, double acceleration) const {
    if (duration <= 0) return std::numeric_limits<double>::infinity();
    const double interval = to_seconds(at - stamp);
    return acceleration * interval * interval;
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
  /// Relative to a keyframe that was made of the one before.
  void change_keyframe(const Sim3& before_from_new) {
    camera_from_keyframe = on_new_keyframe(camera_from_keyframe, before_from_new);
    velocity = SE3(velocity.rotation(), velocity.translation() / before_from_new.scale());
  }
};

}  // namespace rastro
