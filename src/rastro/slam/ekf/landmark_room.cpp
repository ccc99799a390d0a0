// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/landmark_room.h"

#include <algorithm>

#include "rastro/slam/ekf/filter.h"
#include "rastro/slam/ekf/observation.h"

namespace rastro {

LandmarkRoom::LandmarkRoom(const EkfOptions& options, std::size_t full_bytes)
    : most_(static_cast<std::size_t>(options.max_landmarks)) {
  if (full_bytes == 0) return;
  const auto fits = [&](std::size_t landmarks) {
    return EkfFilter::bytes_of(landmarks) + landmarks * sizeof(LandmarkRecord) <= full_bytes;
  };
  if (fits(most_)) return;
  limited_by_memory_ = true;
  std::size_t too_many = most_;
  most_ = 0;
  while (too_many - most_ > 1) {
    const std::size_t middle = (most_ + too_many) / 2;
    (fits(middle) ? most_ : too_many) = middle;
  }
}

}  // namespace rastro
