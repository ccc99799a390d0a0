// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/profiles/turn_chain.h"

#include <cmath>
#include <numbers>

namespace rastro {

std::optional<TurnStep> TurnChain::step(GreyView image, int frames) {
  const auto turn = meter_.look(image);
  if (!turn) {
    meter_.keep_as_reference();
    return std::nullopt;
  }
  TurnStep result{.turn = *turn, .reference_from_current = {}};
  if (turn->still) {
    yaw_ = pitch_ = 0.0;
    return result;
  }
  meter_.keep_as_reference();
  const double change_deg = std::abs(turn->yaw / frames - yaw_) * 180.0 / std::numbers::pi;
  result.believed = !turn->weak || change_deg <= options_.max_turn_change_deg;
  if (result.believed) {
    yaw_ = turn->yaw / frames;
    const double pitch = turn->pitch / frames;
    pitch_ = pitch - pitch_bias_;
    pitch_bias_ += options_.pitch_forgetting * (pitch - pitch_bias_);
  } else {
    pitch_ = 0.0;
  }
  result.reference_from_current = rotation_of(yaw_ * frames, pitch_ * frames);
  return result;
}

}  // namespace rastro
