// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "rastro/map/landmark/landmark_map.h"

namespace rastro {

// Bodies of the rows of a map of landmarks. The readers throw Error naming `where` for anything that is not as it was
// written.
std::string head_body(const LandmarkMap& map);  ///< What is no list.
/// Whether a head is one of these: what tells the kind of a map whose tables are lost.
bool is_landmark_head(std::string_view body);
void read_head(std::string_view body, const std::string& where, LandmarkMap& map);
std::string body_of(const LandmarkKeyframe& keyframe);
std::shared_ptr<const LandmarkKeyframe> read_landmark_keyframe(std::string_view body, std::int64_t id,
                                                               const std::string& where);
std::string body_of(const LandmarkKeyframePose& pose);
LandmarkKeyframePose read_landmark_keyframe_pose(std::string_view body, const std::string& where);
std::string body_of(const Landmark& landmark);
Landmark read_landmark(std::string_view body, std::int64_t id, const std::string& where);
std::string body_of(const LandmarkTie& tie);
LandmarkTie read_tie(std::string_view body, const std::string& where);

}  // namespace rastro
