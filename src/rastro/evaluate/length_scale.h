// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/evaluate/map_lengths.h"

namespace rastro {

/// Scales all lengths by the factor that makes the one of this name as long as it truly is, and takes that one out.
/// Sigmas grow by its relative sigma. The factor; nothing, and the lengths as they were, where it was not measured.
/// Precondition: one of the lengths has this name, and its true length is known.
std::optional<double> scale_by_known_length(std::vector<MeasuredLength>& lengths, const std::string& name);

}  // namespace rastro
