// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "rastro/map/file/map_file.h"
#include "rastro/map/keyframe/rgbd_map.h"

namespace rastro {

/// The tables of map files. All have the same columns: a number, a checksum, and a body.
enum class MapTable : std::uint8_t { head, keyframes, pictures, poses, edges, way, contents, landmarks, ties };
constexpr std::array<MapTable, 9> map_tables = {MapTable::head,     MapTable::keyframes, MapTable::pictures,
                                                MapTable::poses,    MapTable::edges,     MapTable::way,
                                                MapTable::contents, MapTable::landmarks, MapTable::ties};
const char* name_of(MapTable table);
/// Those of one kind of map, in the order in which they are written.
std::span<const MapTable> tables_of(MapKind kind);

/// Over everything of a row, the table's name included: a row in the wrong place does not pass.
std::int64_t row_checksum(MapTable table, std::int64_t id, std::string_view body);

// Bodies of rows. The readers throw Error naming `where` for anything that is not as it was written.
std::string head_body(const RgbdMap& map);  ///< What is no list.
void read_head(std::string_view body, const std::string& where, RgbdMap& map);
std::string body_of(const RgbdKeyframe& keyframe);
std::shared_ptr<const RgbdKeyframe> read_keyframe(std::string_view body, std::int64_t id, const std::string& where);
std::string body_of(const PackedPictures& pictures);
PackedPictures read_pictures(std::string_view body, const std::string& where);
std::string body_of(const KeyframePose& pose);
KeyframePose read_pose(std::string_view body, const std::string& where);
std::string body_of(const PoseEdge& edge);
PoseEdge read_edge(std::string_view body, const std::string& where);
std::string body_of(const StampedPose& pose);
StampedPose read_stamped_pose(std::string_view body, const std::string& where);

}  // namespace rastro
