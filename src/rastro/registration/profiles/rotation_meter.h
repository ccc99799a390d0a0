// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/so3.h"
#include "rastro/registration/profiles/expansion.h"
#include "rastro/registration/profiles/profile.h"
#include "rastro/registration/profiles/rotation_options.h"

namespace rastro {

/// The rotation between two frames as measured from their profiles.
struct ProfileRotation {
  double yaw = 0.0;    ///< Radians, positive to the left.
  double pitch = 0.0;  ///< Radians, positive upwards; 0 without row profiles.
  bool still = false;  ///< No motion.
  bool weak = false;   ///< The minimum is hardly lower than others.
  ExpandingShift columns, rows;
};

/// Rotation of a camera (x right, y down) by yaw and pitch: previous_from_current.
SO3 rotation_of(double yaw, double pitch);

/// Measures rotations from intensity profiles, METHODS 2.2, with extensions: equal angles, the far scene, passing
/// walls, pitch, confidence. About 0.25 ms per frame at 1241 x 376.
class RotationMeter {
 public:
  /// Throws Error for settings out of range.
  RotationMeter(const RotationOptions& options, const Camera& camera);

  /// Computes the profiles of a frame; all frames must have one size. Then measures against the reference, if there is
  /// one; nullopt otherwise.
  std::optional<ProfileRotation> measure(GrayView image);
  /// Makes the last measured frame the reference of the following measurements.
  void keep_as_reference();

 private:
  struct Axis {
    AngleScale scale;
    ExpansionModel model;
    Profile raw, current, reference;
  };
  void prepare(GrayView image);
  void shape(Axis& axis) const;
  ExpandingShift measure(Axis& axis, int max_shift);

  RotationOptions options_;
  Camera camera_;
  bool prepared_ = false, has_reference_ = false;
  Axis columns_, rows_;
  ExpandingShiftFinder finder_;
};

}  // namespace rastro
