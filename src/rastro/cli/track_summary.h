// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "rastro/session/track_run.h"

namespace rastro::cli {

/// What a person wants to know after a run: what came out, where it is, what looks wrong and what to do about it.
std::string track_summary(const TrackRunEnd& end, const std::string& folder,
                          const std::vector<std::pair<std::string, std::string>>& contents,
                          const std::vector<std::string>& hints);

/// What looks wrong with a run, one line each with what to do.
std::vector<std::string> hints_for(const TrackRunEnd& end);

}  // namespace rastro::cli
