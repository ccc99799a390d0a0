// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <string>
#include <string_view>

#include "rastro/map/graph/map.h"

namespace rastro {

// Bodies of the rows of the pose graph. The readers throw Error naming `where` for any invalid body.
std::string head_body(const Map& map);  ///< Method and revision.
/// Whether a head is that of a map with layers.
bool is_layered_head(std::string_view body);
void read_head(std::string_view body, const std::string& where, Map& map);
std::string body_of(const MapCamera& camera);
MapCamera read_camera(std::string_view body, const std::string& where);
std::string body_of(const MapSession& session);
MapSession read_session(std::string_view body, const std::string& where);
std::string body_of(const Keyframe& keyframe);
Keyframe read_keyframe(std::string_view body, KeyframeId id, const std::string& where);
std::string body_of(const Constraint& constraint);
Constraint read_constraint(std::string_view body, const std::string& where);
std::string body_of(const MapFrame& frame);
MapFrame read_frame(std::string_view body, const std::string& where);

}  // namespace rastro
