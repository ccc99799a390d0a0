// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/run_loop.h"

#include <fmt/format.h>

#include "rastro/base/error.h"

namespace rastro {
namespace {

void keep(RunLoopEnd& end, const std::string& what) {
  if (end.failure) return;
  end.failure = std::current_exception();
  end.ended = what;
}

}  // namespace

void run_guarded(RunLoopEnd& end, const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    keep(end, error.what());
  } catch (const std::exception& error) {
    keep(end, fmt::format("fault: {}", error.what()));
  }
}

RunLoopEnd run_loop(FrameReader& reader, const LiveInput* live, const std::atomic<bool>* stop,
                    const std::function<void(Frame&)>& process) {
  RunLoopEnd end;
  const auto interrupt = [&end] {
    end.interrupted = true;
    end.ended = "interrupted";
  };
  run_guarded(end, [&] {
    while (auto frame = reader.next()) {
      if (stop && stop->load()) return interrupt();
      process(*frame);
    }
    if (live && live->was_stopped()) interrupt();
  });
  return end;
}

}  // namespace rastro
