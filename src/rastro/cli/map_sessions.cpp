// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/map_sessions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "rastro/base/text.h"

namespace rastro::cli {
namespace {

bool is_of(const Keyframe& keyframe, const MapSession& session) {
  const KeyframeOrigin origin = origin_of(keyframe.id);
  return origin.robot == session.robot && origin.session == session.session;
}

bool ids_tell(const Map& map) {
  return std::any_of(map.keyframes.begin(), map.keyframes.end(),
                     [&](const Keyframe& keyframe) { return !is_of(keyframe, map.sessions.front()); });
}

std::optional<std::size_t> session_in_id(const Map& map, const Keyframe& keyframe) {
  for (std::size_t s = 0; s < map.sessions.size(); ++s)
    if (is_of(keyframe, map.sessions[s])) return s;
  return std::nullopt;
}

/// From this session on; the last one if none has the stamp.
std::size_t session_at(const Map& map, TimeNs stamp, std::size_t from) {
  for (std::size_t s = from; s < map.sessions.size(); ++s)
    if (stamp >= map.sessions[s].first_stamp && stamp <= map.sessions[s].last_stamp) return s;
  return map.sessions.size() - 1;
}

}  // namespace

std::vector<std::optional<std::size_t>> sessions_of_keyframes(const Map& map) {
  std::vector<std::optional<std::size_t>> sessions(map.keyframes.size());
  if (map.sessions.empty()) return sessions;
  const bool by_id = ids_tell(map);
  std::size_t last = 0;
  TimeNs last_stamp = std::numeric_limits<TimeNs>::min();
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    if (by_id) {
      sessions[k] = session_in_id(map, keyframe);
    } else {
      sessions[k] = last = session_at(map, keyframe.stamp, keyframe.stamp <= last_stamp ? last + 1 : last);
    }
    last_stamp = keyframe.stamp;
  }
  return sessions;
}

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
