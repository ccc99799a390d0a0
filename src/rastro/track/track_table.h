// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rastro/track/track_frame.h"

namespace rastro {

/// The tracks of a whole run in memory, for scoring. Runs themselves stream and do not need it.
struct TrackTable {
  std::vector<TrackFrame> frames;
};

}  // namespace rastro
