// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/registration/profiles/rotation_meter.h"

namespace rastro {

/// Result of RotationChain for a frame.
struct RotationStep {
  ProfileRotation measured;    ///< As measured from the profiles.
  SO3 reference_from_current;  ///< As accepted.
  bool believed = true;        ///< False: the last rotation was repeated, as the measured one was weak and far from it.
};

/// Rotations from frame to frame. Each usable frame is measured against the last usable one that was not still, so that
/// neither a rejected frame nor a creeping motion loses any rotation.
class RotationChain {
 public:
  /// Throws Error for settings out of range.
  RotationChain(const RotationOptions& options, const Camera& camera) : options_(options), meter_(options, camera) {}

  /// nullopt for the first frame. `frames`: steps of the recording since the previous call.
  std::optional<RotationStep> step(GrayView image, int frames);
  /// The last accepted rotation of one frame, previous_from_next.
  SO3 last_rotation() const { return rotation_of(yaw_, pitch_); }

 private:
  RotationOptions options_;
  RotationMeter meter_;
  double yaw_ = 0.0, pitch_ = 0.0;  ///< Radians per frame.
  double pitch_bias_ = 0.0;         ///< Running mean of the measured pitch, radians per frame.
};

}  // namespace rastro
