// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>

#include "rastro/base/time.h"
#include "rastro/viewer/live_messages.h"

namespace rastro {

/// The small images that pages were sent, so that places of maps without images can be shown. From any thread.
class SeenImages {
 public:
  /// Its features are not kept. Where all take too much memory, every second one is given up.
  void add(TimeNs stamp, LiveImage image);
  /// Of the nearest stamp; nullopt where none is near: keyframes of other recordings have other stamps.
  std::optional<LiveImage> near(TimeNs stamp) const;

 private:
  static constexpr std::size_t most_bytes = 32'000'000;
  mutable std::mutex mutex_;
  std::map<TimeNs, LiveImage> images_;
  std::size_t bytes_ = 0;
};

}  // namespace rastro
