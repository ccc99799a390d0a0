// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/orb/map/fused_landmarks.h"

#include <algorithm>

namespace rastro {

void FusedLandmarks::add(std::int64_t gone, std::int64_t kept) {
  if (latest_.size() >= least_) {
    std::swap(latest_, before_);
    latest_.clear();
  }
  latest_.reserve(least_);
  // Landmarks are numbered as they are made, and mostly new ones are fused: near the end.
  const auto at = std::lower_bound(latest_.begin(), latest_.end(), Fused{gone, -1});
  if (at != latest_.end() && at->first == gone)
    at->second = kept;
  else
    latest_.insert(at, {gone, kept});
}

const FusedLandmarks::Fused* FusedLandmarks::find(const std::vector<Fused>& fused, std::int64_t gone) {
  const auto at = std::lower_bound(fused.begin(), fused.end(), Fused{gone, -1});
  return at != fused.end() && at->first == gone ? &*at : nullptr;
}

std::int64_t FusedLandmarks::kept_of(std::int64_t gone) const {
  if (const Fused* fused = find(latest_, gone)) return fused->second;
  if (const Fused* fused = find(before_, gone)) return fused->second;
  return -1;
}

}  // namespace rastro
