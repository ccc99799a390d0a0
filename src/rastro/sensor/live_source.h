// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "rastro/base/time.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/source.h"

namespace rastro {

enum class LiveState : std::uint8_t {
  delivering,
  stalled,  ///< It is there, but no frame has come for longer than usual.
  gone,     ///< Unplugged, closed or forbidden; it is waited for.
  ended,    ///< No frame will come any more.
};

struct LiveCondition {
  LiveState state = LiveState::delivering;
  std::string line;  ///< Why, in words, such as "/dev/video0: unplugged; waiting for it". Empty: nothing to say.
};

/// A frame with the time at which it was taken.
struct ArrivedFrame {
  Frame frame;
  /// Middle of the exposure by the source's clock, or the arrival where nothing tells more.
  TimeNs exposed = 0;
  /// Frames that the device lost since the previous one, where it counts them.
  std::int64_t lost_before = 0;
};

/// Frames that come at their own time, from a camera or a recording that is replayed. One thread calls it.
class LiveSource {
 public:
  virtual ~LiveSource() = default;
  virtual const SourceInfo& info() const = 0;
  /// The next frame, waiting at most about `patience` for it; nullopt: none came, condition() says why. Throws Error
  /// for a frame that cannot be read, and UnusableSource where no later one can.
  virtual std::optional<ArrivedFrame> next(TimeNs patience) = 0;
  virtual LiveCondition condition() const = 0;
};

}  // namespace rastro
