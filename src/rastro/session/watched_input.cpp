// SPDX-License-Identifier: Apache-2.0
#include "rastro/session/watched_input.h"

#include <nlohmann/json.hpp>

#include "rastro/base/log.h"

namespace rastro {

void WatchedInput::add(const Frame& frame) {
  for (const InputWarning& warning : monitor_.add(frame)) {
    log_warning(warning.text);
    if (folder_) folder_->add_event(frame.index, "input_warning", warning.kind + ": " + warning.text);
  }
}

nlohmann::ordered_json json_of(const InputWarnings& warnings) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const InputWarning& warning : warnings) list.push_back({{"kind", warning.kind}, {"text", warning.text}});
  return list;
}

}  // namespace rastro
