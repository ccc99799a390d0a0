// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace rastro {

/// Resident memory of this process in 10^6 bytes, as limits and results count them, from /proc/self/status; 0 where
/// that does not exist.
double resident_memory_mb();
double peak_resident_memory_mb();

/// Gives what was freed back to the system, which counts it as resident until then.
void return_freed_memory();

}  // namespace rastro
