// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/log.h"

#include <mutex>
#include <utility>

namespace rastro {
namespace {

struct Sink {
  std::mutex mutex;
  std::function<void(LogLevel, const std::string&)> call;
};

Sink& sink() {
  static Sink instance;
  return instance;
}

}  // namespace

void set_log_sink(std::function<void(LogLevel, const std::string&)> new_sink) {
  const std::lock_guard lock(sink().mutex);
  sink().call = std::move(new_sink);
}

void log(LogLevel level, const std::string& line) {
  const std::lock_guard lock(sink().mutex);
  if (sink().call) sink().call(level, line);
}

}  // namespace rastro
