// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "rastro/input_check/input_monitor.h"
#include "rastro/session/run_folder.h"

namespace rastro {

/// The input monitor of a run: what becomes sure is logged, and is an event of the frame.
class WatchedInput {
 public:
  /// `folder` may be null.
  WatchedInput(const SourceInfo& info, RunFolder* folder) : monitor_(info), folder_(folder) {}

  void add(const Frame& frame);
  const InputWarnings& warnings() const { return monitor_.warnings(); }

 private:
  InputMonitor monitor_;
  RunFolder* folder_;
};

/// The field "warnings" of result.json.
nlohmann::ordered_json json_of(const InputWarnings& warnings);

}  // namespace rastro
