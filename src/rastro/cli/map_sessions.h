// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "rastro/map/graph/map.h"

namespace rastro::cli {

/// What one session added to a map.
struct SessionShare {
  std::size_t keyframes = 0;
  std::set<int> submaps;  ///< Of these keyframes.
};

/// In the order of the sessions.
std::vector<SessionShare> session_shares(const Map& map);

/// "1000.000 .. 1012.500 s, 14 keyframes in submap 0, of PATH".
std::string session_text(const MapSession& session, const SessionShare& share);

}  // namespace rastro::cli
