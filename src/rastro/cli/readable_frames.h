// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "rastro/base/log.h"
#include "rastro/sensor/source.h"

namespace rastro::cli {

/// The next frame that can be read, after a warning of each that cannot; nullopt at the end. UnusableSource is passed
/// on, as is the error of a source that only fails.
inline std::optional<Frame> next_readable(Source& source) {
  constexpr int most_failures = 100'000;
  for (int failures = 1;; ++failures) {
    try {
      return source.next();
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      if (failures == most_failures) throw;
      log_warning(error.what());
    }
  }
}

}  // namespace rastro::cli
