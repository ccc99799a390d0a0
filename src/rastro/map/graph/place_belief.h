// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/map/graph/keyframe_id.h"

namespace rastro {

/// What a method that recognizes places took a keyframe for when it was made.
struct PlaceBelief {
  KeyframeId keyframe = no_keyframe;
  double new_place = 1.0;            ///< Probability that no known location is seen.
  KeyframeId likely = no_keyframe;   ///< Its most likely known location; no_keyframe: none is known.
  double probability = 0.0;          ///< Of `likely`.
  double threshold = 0.0;            ///< Probability from which a location is compared with the keyframe.
  std::vector<KeyframeId> accepted;  ///< Keyframes of earlier places that it was matched with.
  std::vector<KeyframeId> rejected;  ///< Locations that look like it, but whose geometry does not fit.
};

}  // namespace rastro
