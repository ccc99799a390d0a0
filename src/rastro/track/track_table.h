// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/track/track_frame.h"

namespace rastro {

/// The tracks of a whole run in memory, for scoring; runs themselves stream and never need it.
struct TrackTable {
  std::vector<TrackFrame> frames;
};

}  // namespace rastro
