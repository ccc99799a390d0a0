// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/registration/profiles/rotation_meter.h"

namespace rastro {

/// What RotationChain makes of a frame.
struct RotationStep {
  ProfileRotation measured;    ///< As the profiles tell it.
  SO3 reference_from_current;  ///< As believed.
  bool believed = true;  ///< False: the last rotation was carried on, as the measured one was weak and far from it.
};

/// Rotations from frame to frame: each useful frame is measured against the last useful one that was not still, so that
/// neither a frame without use nor a creeping motion loses anything.
class RotationChain {
 public:
  /// Throws Error for settings out of range.
  RotationChain(const RotationOptions& options, const Camera& camera) : options_(options), meter_(options, camera) {}

  /// nullopt for the first frame. `frames`: steps of the recording since the frame before.
  std::optional<RotationStep> step(GreyView image, int frames);
  /// The rotation of one frame as last believed, previous_from_next.
  SO3 last_rotation() const { return rotation_of(yaw_, pitch_); }

 private:
  RotationOptions options_;
  RotationMeter meter_;
  double yaw_ = 0.0, pitch_ = 0.0;  ///< Radians a frame.
  double pitch_bias_ = 0.0;         ///< Running mean of the pitch measured, radians a frame.
};

}  // namespace rastro
