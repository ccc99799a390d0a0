// SPDX-License-Identifier: Apache-2.0
// Relations: whatever the text, they are read or refused with rastro::Error; what is read can be scored.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rastro/base/error.h"
#include "rastro/evaluate/relations.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto relations = rastro::parse_relations({reinterpret_cast<const char*>(data), size}, "input");
    rastro::Trajectory trajectory(2);
    trajectory[1].stamp = rastro::ns_per_second;
    const auto scores = rastro::score_relations(relations, trajectory, rastro::ns_per_second);
    if (scores.relations + scores.skipped != static_cast<std::int64_t>(relations.size())) __builtin_trap();
    if (!std::isfinite(scores.trans_mean_m) || !std::isfinite(scores.rot_sigma_deg)) __builtin_trap();
  } catch (const rastro::Error&) {
  }
  return 0;
}
