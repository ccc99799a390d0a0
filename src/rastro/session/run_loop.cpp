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

RunLoopEnd run_loop(FrameReader& reader, const std::atomic<bool>* stop, const std::function<void(Frame&)>& process) {
  RunLoopEnd end;
  run_guarded(end, [&] {
    while (auto frame = reader.next()) {
      if (stop && stop->load()) {
        end.interrupted = true;
        end.ended = "interrupted";
        return;
      }
      process(*frame);
    }
  });
  return end;
}

}  // namespace rastro
