// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/frame_reader.h"

#include "rastro/base/error.h"

namespace rastro {

std::optional<Frame> FrameReader::next() {
  // A source that only fails must not keep the run going forever.
  constexpr int failures_in_a_row = 100'000;
  for (int failures = 0;; ++failures) {
    try {
      std::optional<Frame> frame = source_.next();
      if (frame) last_index_ = frame->index;
      return frame;
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      if (first_skip_.empty()) first_skip_ = error.what();
      ++skipped_;
      if (folder_) folder_->add_event(last_index_, "frame skipped", error.what());
      if (failures >= failures_in_a_row) throw;
    }
  }
}

}  // namespace rastro
