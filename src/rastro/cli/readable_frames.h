// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/base/log.h"
#include "rastro/sensor/source.h"

namespace rastro::cli {

/// The next frame that can be read, after a warning of each that cannot; nullopt at the end. UnusableSource is passed
/// on.
inline std::optional<Frame> next_readable(Source& source) {
  for (;;) {
    try {
      return source.next();
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      log_warning(error.what());
    }
  }
}

}  // namespace rastro::cli
