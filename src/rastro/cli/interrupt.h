// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

namespace rastro::cli {

/// From here on Ctrl-C (SIGINT) and SIGTERM set the flag returned instead of ending the program; a second one ends it.
const std::atomic<bool>& catch_interrupts();

}  // namespace rastro::cli
