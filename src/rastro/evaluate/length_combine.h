// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace rastro {

/// Position of a feature in one keyframe, along the measured direction.
struct LengthObservation {
  std::int64_t keyframe = 0;
  double value_m = 0.0;
  double sigma_m = 0.0;   ///< Standard deviation of the keyframe's own measurement, without that of its pose.
  double shared_m = 0.0;  ///< Standard deviation of the error common to all keyframes.
  /// Derivative of the value by the height of the face of the feature, where only that is unknown (no depth).
  double lever = 0.0;
};

/// One end of a length. At most one observation per keyframe.
struct LengthObservations {
  std::vector<LengthObservation> all;
  /// Prior of the height of the face, for observations with a lever: mean and standard deviation, meters.
  double height_m = 0.0, height_sigma_m = 0.0;
};

struct CombinedLength {
  double length_m = 0.0;  ///< b - a
  double sigma_m = 0.0;
  int seen_a = 0, seen_b = 0, together = 0;  ///< Keyframes that agree; those that observe both.
  double height_sigma_m = 0.0;               ///< Of the height of the face, of the end where it is less certain.
  double pose_sigma_m = 0.0;                 ///< Scatter of the keyframe poses beyond their measurement noise.
  double scatter_m = 0.0;  ///< Of the lengths of keyframes that observe both, else of the values of each feature.
};

/// Generalized least squares over all keyframes. The pose error of a keyframe moves both features together, so
/// keyframes that observe both give the length without their poses, while for those that observe one the scatter of the
/// poses is added. Heights of faces without depth are estimated jointly: keyframes that view them from different sides
/// determine them. Outliers are rejected. nullopt if one of the features has no observation.
std::optional<CombinedLength> combine_lengths(LengthObservations a, LengthObservations b);

}  // namespace rastro
