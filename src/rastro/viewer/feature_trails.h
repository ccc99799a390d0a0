// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <unordered_map>

#include "rastro/viewer/live_messages.h"

namespace rastro {

/// Where features that keep an id were in the last frames.
class FeatureTrails {
 public:
  /// The features of the next frame. An id that is missing for some frames keeps its trail, for it may be
  /// re-identified.
  void add(const LiveFeatures& features);
  /// Sets the trails of features that were added.
  void write_to(LiveFeatures& features) const;

 private:
  static constexpr std::size_t longest = 24;
  static constexpr std::int64_t most_missing = 40;  ///< Frames.
  struct Trail {
    std::deque<std::array<float, 2>> pixels;
    std::int64_t frame = 0;  ///< That had it last.
  };
  std::unordered_map<std::int32_t, Trail> trails_;
  std::int64_t frame_ = 0;
};

}  // namespace rastro
