// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <string>

#include "rastro/session/frame_reader.h"

namespace rastro {

/// How a run came to its end.
struct RunLoopEnd {
  bool interrupted = false;
  std::string ended = "end of data";  ///< Or "interrupted", or the error that ended the run.
  std::exception_ptr failure;
};

/// Hands every frame that can be read to `process` until the data ends, `stop` is set (may be null) or something
/// throws, which is kept.
RunLoopEnd run_loop(FrameReader& reader, const std::atomic<bool>* stop, const std::function<void(Frame&)>& process);

/// Calls `work`; what it throws is kept in `end`, unless something went wrong before.
void run_guarded(RunLoopEnd& end, const std::function<void()>& work);

}  // namespace rastro
