// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/recover_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/map/file/carve.h"
#include "rastro/map/file/landmark_rows.h"
#include "rastro/map/file/recovered_rows.h"
#include "rastro/map/keyframe/pack_pictures.h"

namespace rastro {
namespace {

class Recovery {
 public:
  explicit Recovery(RecoveredRows& rows) : file_(rows.file), rows_(rows) {}

  RecoveredMap run() {
    read_head_rows();
    count_from_contents();
    take_keyframes();
    take_edges();
    take_way();
    map_->pictures = pictures_;
    result_.map = map_;
    return std::move(result_);
  }

 private:
  RecoveredRows::Rows& of(MapTable table) { return rows_.of(table); }

  void read_head_rows() {
    for (const auto& [table, id] :
         {std::pair(MapTable::head, std::int64_t{0}), {MapTable::contents, second_head_row}}) {
      const auto row = of(table).find(id);
      if (row == of(table).end()) continue;
      if (try_to([&] { return read_head(row->second, file_, *map_), true; })) return;
    }
    throw Error("nothing of a map was found", file_, "give the map.rastro of a run; this one is beyond saving");
  }

  /// How many rows there should be: by the table of contents, else as many as the highest number says.
  void count_from_contents() {
    constexpr std::int64_t most = 1'000'000'000;  // a file may be made to say anything
    for (const MapTable table : map_tables)
      wanted_[static_cast<std::size_t>(table)] =
          of(table).empty() ? 0 : std::clamp<std::int64_t>(of(table).rbegin()->first, -1, most) + 1;
    const auto counts = rows_.counts(MapKind::rgbd);
    result_.finished = counts.has_value();
    if (counts) wanted_ = *counts;
  }

  std::int64_t wanted(MapTable table) const { return wanted_[static_cast<std::size_t>(table)]; }

  void take_keyframes() {
    for (const auto& [id, body] : of(MapTable::keyframes)) take_keyframe(id, body);
    const std::int64_t all =
        std::max({wanted(MapTable::keyframes), wanted(MapTable::poses), wanted(MapTable::pictures)});
    const std::int64_t lost = all - static_cast<std::int64_t>(map_->keyframes.size());
    if (lost > 0) result_.lost.push_back(fmt::format("{} of {} keyframes ({})", lost, all, first_missing(lost)));
  }

  std::string first_missing(std::int64_t lost) const {
    constexpr std::int64_t most = 10;
    std::string which;
    std::int64_t named = 0;
    for (std::int64_t id = 0; named < std::min(lost, most); ++id)
      if (!new_number_.contains(id)) which += fmt::format("{}{}", named++ == 0 ? "" : ", ", id);
    return which + (lost > most ? ", ..." : "");
  }

  void take_keyframe(std::int64_t id, const std::string& features) {
    const auto pose_row = of(MapTable::poses).find(id);
    const auto pictures_row = of(MapTable::pictures).find(id);
    if (pose_row == of(MapTable::poses).end() || pictures_row == of(MapTable::pictures).end()) return;
    const auto number = static_cast<std::int64_t>(map_->keyframes.size());
    const auto keyframe = try_to([&] { return read_keyframe(features, number, file_); });
    const auto pose = try_to([&] { return read_pose(pose_row->second, file_); });
    auto pictures = try_to([&] { return read_pictures(pictures_row->second, file_); });
    if (!keyframe || !pose || !pictures) return;
    map_->keyframes.push_back(*keyframe);
    map_->poses.push_back(*pose);
    pictures_->add(number, std::move(*pictures));
    pictures_row->second.clear();
    new_number_[id] = number;
  }

  void take_edges() {
    for (const auto& row : of(MapTable::edges)) {
      auto edge = try_to([&] { return read_edge(row.second, file_); });
      if (!edge || !new_number_.contains(edge->from) || !new_number_.contains(edge->to)) continue;
      edge->from = new_number_[edge->from];
      edge->to = new_number_[edge->to];
      map_->edges.push_back(*edge);
    }
    say_lost(result_, map_->edges.size(), wanted(MapTable::edges), "edges");
  }

  void take_way() {
    for (const auto& row : of(MapTable::way))
      if (const auto pose = try_to([&] { return read_stamped_pose(row.second, file_); }))
        map_->trajectory.push_back(*pose);
    say_lost(result_, map_->trajectory.size(), wanted(MapTable::way), "poses of the way");
  }

  const std::string& file_;
  RecoveredRows& rows_;
  std::array<std::int64_t, map_tables.size()> wanted_{};
  std::shared_ptr<RgbdMap> map_ = std::make_shared<RgbdMap>();
  std::shared_ptr<MemoryPictures> pictures_ = std::make_shared<MemoryPictures>();
  std::map<std::int64_t, std::int64_t> new_number_;
  RecoveredMap result_;
};

}  // namespace

RecoveredMap recover_map(const std::filesystem::path& file) {
  RecoveredRows rows(file.string());
  carve_rows(file, [&](MapTable table, std::int64_t id, const std::string& body) { rows.of(table)[id] = body; });
  for (const auto& [table, id] : {std::pair(MapTable::head, std::int64_t{0}), {MapTable::contents, second_head_row}}) {
    const auto row = rows.of(table).find(id);
    if (row != rows.of(table).end() && is_landmark_head(row->second)) return recover_landmark_map(rows);
  }
  return Recovery(rows).run();
}

}  // namespace rastro
