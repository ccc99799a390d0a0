// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "rastro/session/track_run.h"

namespace rastro::cli {

/// Summary of a run: results, where they are, what looks wrong and how to fix it.
std::string track_summary(const TrackRunEnd& end, const std::string& folder,
                          const std::vector<std::pair<std::string, std::string>>& contents,
                          const std::vector<std::string>& hints);

/// What looks wrong with a run and how to fix it, a line each.
std::vector<std::string> hints_for(const TrackRunEnd& end);

}  // namespace rastro::cli
