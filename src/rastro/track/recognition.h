// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/track/klt.h"
#include "rastro/track/options.h"
#include "rastro/track/track_frame.h"
#include "rastro/track/track_store.h"
#include "rastro/track/validation.h"

namespace rastro {

/// The descriptor of a corner, or several at different scales.
using Describe = std::function<std::vector<Descriptor>(const Eigen::Vector2f& corner)>;

/// A corner re-identified as a lost track.
struct Recognized {
  std::size_t corner = 0;
  std::size_t track = 0;
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< The corner's, or its position after alignment.
};

/// METHODS 1, steps 4 to 8: match, vote, align, validate. At most `most` corners are re-identified, each at least
/// `min_distance_px` from the others. An id claimed by two corners goes to the one with more votes, then smaller
/// distance, then the stronger corner. `tracked`: the features tracked into the current frame. The result does not
/// depend on the pool. `describe` is called for corners near which a lost feature may reappear, from several threads
/// where there is a pool.
std::vector<Recognized> recognize(std::span<const Eigen::Vector2f> corners, const Describe& describe,
                                  std::span<const Association> tracked, const TrackStore& store, std::int64_t current,
                                  const Pyramid& image, int most, const TrackOptions& options, TaskPool* pool,
                                  TrackTimes& times);

}  // namespace rastro
