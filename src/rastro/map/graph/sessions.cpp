// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/graph/sessions.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

namespace rastro {
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

bool is_within(TimeNs stamp, const MapSession& session) {
  return stamp >= session.first_stamp && stamp <= session.last_stamp;
}

/// From this session on; `if_none` where none has the stamp.
std::size_t session_at(const Map& map, TimeNs stamp, std::size_t from, std::size_t if_none) {
  for (std::size_t s = from; s < map.sessions.size(); ++s)
    if (is_within(stamp, map.sessions[s])) return s;
  return if_none;
}

using Span = std::pair<TimeNs, TimeNs>;

/// Of the frames of each session that has any.
std::vector<Span> spans_of_sessions(const Map& map) {
  const std::vector<std::size_t> sessions = sessions_of_frames(map);
  constexpr Span nothing{std::numeric_limits<TimeNs>::max(), std::numeric_limits<TimeNs>::min()};
  std::vector<Span> spans(map.sessions.size(), nothing);
  for (std::size_t k = 0; k < sessions.size(); ++k) {
    Span& span = spans[sessions[k]];
    span = {std::min(span.first, map.frames[k].stamp), std::max(span.second, map.frames[k].stamp)};
  }
  std::erase(spans, nothing);
  return spans;
}

/// In the order of time, each stamp once. nullopt: of all sessions.
Trajectory poses_of(const Map& map, const std::set<int>& submaps, std::optional<std::size_t> session) {
  const std::vector<std::size_t> sessions = session ? sessions_of_frames(map) : std::vector<std::size_t>();
  Trajectory trajectory;
  for (std::size_t k = 0; k < map.frames.size(); ++k) {
    const MapFrame& frame = map.frames[k];
    if (session && sessions[k] != *session) continue;
    const Keyframe* keyframe = map.find(frame.keyframe);
    if (keyframe && submaps.contains(keyframe->submap))
      trajectory.push_back({frame.stamp, keyframe->world_from_camera * frame.keyframe_from_camera});
  }
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.stamp == b.stamp; };
  trajectory.erase(std::unique(trajectory.begin(), trajectory.end(), same), trajectory.end());
  return trajectory;
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
      const std::size_t from = keyframe.stamp <= last_stamp ? last + 1 : last;
      sessions[k] = last = session_at(map, keyframe.stamp, from, map.sessions.size() - 1);
    }
    last_stamp = keyframe.stamp;
  }
  return sessions;
}

std::vector<std::size_t> sessions_of_frames(const Map& map) {
  std::vector<std::size_t> sessions(map.frames.size(), 0);
  std::size_t last = 0;
  TimeNs last_stamp = std::numeric_limits<TimeNs>::min();
  for (std::size_t k = 0; k < map.frames.size() && map.sessions.size() > 1; ++k) {
    const TimeNs stamp = map.frames[k].stamp;
    const bool goes_on = stamp > last_stamp && is_within(stamp, map.sessions[last]);
    if (!goes_on) last = session_at(map, stamp, k == 0 ? 0 : last + 1, last);
    sessions[k] = last;
    last_stamp = stamp;
  }
  return sessions;
}

bool sessions_overlap(const Map& map) {
  if (map.sessions.size() < 2) return false;
  std::vector<Span> spans = spans_of_sessions(map);
  std::sort(spans.begin(), spans.end());
  return std::adjacent_find(spans.begin(), spans.end(), [](const Span& earlier, const Span& later) {
           return later.first <= earlier.second;
         }) != spans.end();
}

Trajectory trajectory_of_session(const Map& map, std::size_t session, int submap) {
  return poses_of(map, {submap}, session);
}

Trajectory trajectory_of(const Map& map, const std::set<int>& submaps) {
  if (!sessions_overlap(map)) return poses_of(map, submaps, std::nullopt);
  for (std::size_t session = map.sessions.size(); session > 0; --session)
    if (Trajectory last = poses_of(map, submaps, session - 1); !last.empty()) return last;
  return {};
}

Trajectory trajectory_of(const Map& map, int submap) { return trajectory_of(map, std::set<int>{submap}); }

}  // namespace rastro
