// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

namespace rastro {

/// Maps the running numbers of a tracker (0, 1, 2, ...) to frame numbers of the recording. Memory grows only with
/// changes of the step between frames, that is with skipped frames, not with the run.
class FrameNumbers {
 public:
  /// Frame number of the next running number; ascending.
  void add(std::int64_t recorded) {
    if (!pieces_.empty()) {
      Piece& last = pieces_.back();
      if (next_ - last.running == 1) last.step = recorded - last.recorded;
      if (recorded == last.recorded + (next_ - last.running) * last.step) {
        ++next_;
        return;
      }
    }
    pieces_.push_back({next_++, recorded, 1});
  }

  /// -1 stays -1: "never".
  std::int64_t recorded(std::int64_t running) const {
    if (running < 0 || pieces_.empty()) return -1;
    const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), running,
                                        [](std::int64_t value, const Piece& piece) { return value < piece.running; });
    const Piece& piece = *std::prev(after);
    return piece.recorded + (running - piece.running) * piece.step;
  }

 private:
  struct Piece {
    std::int64_t running, recorded, step;
  };
  std::vector<Piece> pieces_;
  std::int64_t next_ = 0;
};

}  // namespace rastro
