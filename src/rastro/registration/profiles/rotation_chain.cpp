// SPDX-License-Identifier: Apache-2.0
#include "rastro/registration/profiles/rotation_chain.h"

#include <cmath>
#include <numbers>

namespace rastro {

std::optional<RotationStep> RotationChain::step(GrayView image, int frames) {
  const auto measured = meter_.measure(image);
  if (!measured) {
    meter_.keep_as_reference();
    return std::nullopt;
  }
  RotationStep result{.measured = *measured, .reference_from_current = {}};
  if (measured->still) {
    yaw_ = pitch_ = 0.0;
    return result;
  }
  meter_.keep_as_reference();
  const double change_deg = std::abs(measured->yaw / frames - yaw_) * 180.0 / std::numbers::pi;
  result.believed = !measured->weak || change_deg <= options_.max_rotation_change_deg;
  if (result.believed) {
    yaw_ = measured->yaw / frames;
    const double pitch = measured->pitch / frames;
    pitch_ = pitch - pitch_bias_;
    pitch_bias_ += options_.pitch_forgetting * (pitch - pitch_bias_);
  } else {
    pitch_ = 0.0;
  }
  result.reference_from_current = rotation_of(yaw_ * frames, pitch_ * frames);
  return result;
}

}  // namespace rastro
