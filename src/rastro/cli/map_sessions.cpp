// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/map_sessions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rastro/base/text.h"
#include "rastro/map/graph/sessions.h"

namespace rastro::cli {

std::vector<SessionShare> session_shares(const Map& map) {
  std::vector<SessionShare> shares(map.sessions.size());
  const auto sessions = sessions_of_keyframes(map);
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    if (!sessions[k]) continue;
    ++shares[*sessions[k]].keyframes;
    shares[*sessions[k]].submaps.insert(map.keyframes[k].submap);
  }
  return shares;
}

std::string session_text(const MapSession& session, const SessionShare& share) {
  std::string text = fmt::format("{:.3f} .. {:.3f} s, {} keyframe{}", to_seconds(session.first_stamp),
                                 to_seconds(session.last_stamp), share.keyframes, share.keyframes == 1 ? "" : "s");
  if (!share.submaps.empty())
    text += fmt::format(" in submap{} {}", share.submaps.size() == 1 ? "" : "s", fmt::join(share.submaps, ", "));
  return session.recording.empty() ? text : text + ", of " + one_line(session.recording);
}

}  // namespace rastro::cli
