// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "rastro/base/clock.h"
#include "rastro/sensor/live_source.h"

namespace rastro {

struct ReplayOptions {
  double speed = 1.0;  ///< Times as fast as recorded; more than 0.
  bool loop = false;   ///< From the first frame again after the last; stamps and numbers go on.
};

/// A recording at its own pace: each frame comes when as much time has passed since the first one as between their
/// stamps. `open` gives the recording, for each loop anew. Where frames cannot be read that fast, the replay slows down
/// and says so. `clock` outlives it. Error for a speed out of range.
std::unique_ptr<LiveSource> make_replay(std::function<std::unique_ptr<Source>()> open, const ReplayOptions& options,
                                        Clock& clock);

}  // namespace rastro
