// SPDX-License-Identifier: Apache-2.0
#include "rastro/base/memory.h"

#include <malloc.h>

#include <fstream>
#include <string>

#include "rastro/base/text.h"

namespace rastro {
namespace {

constexpr double mb_per_kib = 1024.0 * 1e-6;

double status_field_mb(std::string_view name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with(name)) continue;
    const auto words = split_words(line);
    return words.size() < 2 ? 0.0 : mb_per_kib * parse_double(words[1]).value_or(0.0);
  }
  return 0.0;
}

}  // namespace

double resident_memory_mb() { return status_field_mb("VmRSS:"); }
double peak_resident_memory_mb() { return status_field_mb("VmHWM:"); }
void return_freed_memory() { ::malloc_trim(0); }

}  // namespace rastro
