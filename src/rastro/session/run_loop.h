// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <string>

#include "rastro/session/frame_reader.h"
#include "rastro/session/live_input.h"

namespace rastro {

/// How a run ended.
struct RunLoopEnd {
  bool interrupted = false;
  std::string ended = "end of data";  ///< Or "interrupted", or the error that ended the run.
  std::exception_ptr failure;
};

/// Passes every readable frame to `process` until the data ends, `stop` is set (may be null) or something throws; the
/// exception is kept. `live`: the source of the reader in a live run, else null.
RunLoopEnd run_loop(FrameReader& reader, const LiveInput* live, const std::atomic<bool>* stop,
                    const std::function<void(Frame&)>& process);

/// Calls `work`; keeps its exception in `end`, unless there is an earlier one.
void run_guarded(RunLoopEnd& end, const std::function<void()>& work);

}  // namespace rastro
