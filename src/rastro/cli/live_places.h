// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <optional>

#include "rastro/map/graph/map.h"
#include "rastro/slam/slam.h"
#include "rastro/viewer/live_messages.h"
#include "rastro/viewer/seen_images.h"

namespace rastro::cli {

/// Which place of a growing map a page is shown: the keyframe of the newest loop closure or relocalization with the
/// place it was matched with, else the newest keyframe. Its features are the visual words in the colors of their kinds
/// where the map has signatures, its pixels in the colors of their depths where it has semi-dense depth.
class LivePlaces {
 public:
  /// A frame of the run, in the run's thread.
  void note(const SlamUpdate& update);
  /// The next map has nothing in common with the last.
  void forget() { forgets_ = true; }
  /// nullopt where there is nothing new, or no image of it. In one other thread.
  std::optional<LivePlace> of(const Map& map, const SeenImages& seen);

 private:
  struct Relocalization {
    std::int64_t frame = 0;
    TimeNs stamp = 0;
    KeyframeId place = no_keyframe;
  };
  std::optional<LivePlace> relocalized(const Map& map, const SeenImages& seen);

  std::mutex mutex_;
  std::optional<Relocalization> relocalization_;  ///< Not shown yet.
  std::atomic<bool> forgets_ = false;
  std::size_t seen_constraints_ = 0;
  KeyframeId shown_ = no_keyframe;
};

}  // namespace rastro::cli
