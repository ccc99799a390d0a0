// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "rastro/slam/ekf/options.h"

namespace rastro {

/// How many landmarks there may be, by `max_landmarks` and memory: the filter has one joint covariance of the body and
/// all of them. The last twentieth is for candidates alone: by them a full map still recognizes places.
class LandmarkRoom {
 public:
  /// `full_bytes`: that filter and records may take; 0: any.
  LandmarkRoom(const EkfOptions& options, std::size_t full_bytes);

  /// With candidates.
  std::size_t most() const { return most_; }
  std::size_t most_confirmed() const { return most_ - most_ / 20; }
  /// Memory sets the limit, not `max_landmarks`.
  bool limited_by_memory() const { return limited_by_memory_; }

 private:
  std::size_t most_;
  bool limited_by_memory_ = false;
};

}  // namespace rastro
