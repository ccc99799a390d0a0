// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace rastro {

/// Id of a keyframe, unique over all robots and sessions: 64 bits, sparse, never reused. Ids are ordered by robot,
/// session and number.
using KeyframeId = std::int64_t;
constexpr KeyframeId no_keyframe = -1;

/// The parts of an id.
struct KeyframeOrigin {
  int robot = 0;            ///< 0 to 2047.
  int session = 0;          ///< Of that robot, 0 to 65535.
  std::int64_t number = 0;  ///< Within the session, 0 to 2^36 - 1.
  bool operator==(const KeyframeOrigin&) const = default;
};

constexpr int keyframe_session_bits = 16, keyframe_number_bits = 36;

/// The parts must be in their ranges.
constexpr KeyframeId keyframe_id(const KeyframeOrigin& origin) {
  return (static_cast<KeyframeId>(origin.robot) << (keyframe_session_bits + keyframe_number_bits)) |
         (static_cast<KeyframeId>(origin.session) << keyframe_number_bits) | origin.number;
}

constexpr KeyframeOrigin origin_of(KeyframeId id) {
  constexpr KeyframeId sessions = KeyframeId{1} << keyframe_session_bits,
                       numbers = KeyframeId{1} << keyframe_number_bits;
  return {static_cast<int>(id / (sessions * numbers)), static_cast<int>(id / numbers % sessions), id % numbers};
}

}  // namespace rastro
