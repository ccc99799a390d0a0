// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/landmark_rows.h"
#include "rastro/map/file/recovered_rows.h"
#include "rastro/map/landmark/keyframe_places.h"
#include "rastro/map/landmark/landmark_checks.h"

namespace rastro {
namespace {

class LandmarkRecovery {
 public:
  explicit LandmarkRecovery(RecoveredRows& rows) : rows_(rows) {}

  RecoveredMap run() {
    read_head_rows();
    const auto counts = rows_.counts(MapKind::landmarks);
    result_.finished = counts.has_value();
    for (const MapTable table : tables_of(MapKind::landmarks))
      wanted_[static_cast<std::size_t>(table)] =
          counts ? (*counts)[static_cast<std::size_t>(table)] : static_cast<std::int64_t>(rows_.of(table).size());
    take_keyframes();
    take_landmarks();
    take_ties();
    take_way();
    settle();
    result_.landmark_map = map_;
    return std::move(result_);
  }

 private:
  std::int64_t wanted(MapTable table) const { return wanted_[static_cast<std::size_t>(table)]; }

  void read_head_rows() {
    for (const auto& [table, id] :
         {std::pair(MapTable::head, std::int64_t{0}), {MapTable::contents, second_head_row}}) {
      const auto row = rows_.of(table).find(id);
      if (row == rows_.of(table).end()) continue;
      if (try_to([&] { return read_head(row->second, rows_.file, *map_), true; })) return;
    }
    throw Error("nothing of a map was found", rows_.file, "give the map.rastro of a run; this one is beyond saving");
  }

  void take_keyframes() {
    auto& poses = rows_.of(MapTable::poses);
    for (const auto& [id, body] : rows_.of(MapTable::keyframes)) {
      const auto pose_row = poses.find(id);
      if (pose_row == poses.end()) continue;
      const auto keyframe =
          try_to([&, &id = id, &body = body] { return read_landmark_keyframe(body, id, rows_.file); });
      const auto pose = try_to([&] { return read_landmark_keyframe_pose(pose_row->second, rows_.file); });
      if (!keyframe || !pose) continue;
      map_->keyframes.push_back(*keyframe);
      map_->poses.push_back(*pose);
    }
    places_.emplace(*map_);
    for (LandmarkKeyframePose& pose : map_->poses)
      if (pose.parent >= 0 && !places_->of(pose.parent)) pose.parent = -1;
    const std::int64_t all = std::max(wanted(MapTable::keyframes), wanted(MapTable::poses));
    say_lost(result_, map_->keyframes.size(), all, "keyframes");
  }

  bool is_seen_by(const LandmarkObservation& observation) const {
    const auto place = places_->of(observation.keyframe);
    return place && observation.feature < map_->keyframes[*place]->features.size();
  }

  void take_landmarks() {
    for (const auto& [id, body] : rows_.of(MapTable::landmarks)) {
      auto landmark = try_to([&, &id = id, &body = body] { return read_landmark(body, id, rows_.file); });
      if (!landmark) continue;
      std::erase_if(landmark->observations, [&](const auto& observation) { return !is_seen_by(observation); });
      if (!landmark->observations.empty()) map_->landmarks.push_back(std::move(*landmark));
    }
    say_lost(result_, map_->landmarks.size(), wanted(MapTable::landmarks), "landmarks");
  }

  void take_ties() {
    for (const auto& row : rows_.of(MapTable::ties)) {
      const auto tie = try_to([&] { return read_tie(row.second, rows_.file); });
      if (tie && places_->of(tie->from) && places_->of(tie->to)) map_->ties.push_back(*tie);
    }
    say_lost(result_, map_->ties.size(), wanted(MapTable::ties), "ties");
  }

  void take_way() {
    for (const auto& row : rows_.of(MapTable::way))
      if (const auto pose = try_to([&] { return read_stamped_pose(row.second, rows_.file); }))
        map_->trajectory.push_back(*pose);
    say_lost(result_, map_->trajectory.size(), wanted(MapTable::way), "poses of the way");
  }

  /// Rows of one run fit each other; those of a file that somebody made need not.
  void settle() {
    if (contradiction_in(*map_).empty()) return;
    for (LandmarkKeyframePose& pose : map_->poses) pose.parent = -1;
    const std::string fault = contradiction_in(*map_);
    if (!fault.empty()) throw Error(fault, rows_.file, "this one is beyond saving");
  }

  RecoveredRows& rows_;
  std::array<std::int64_t, map_tables.size()> wanted_{};
  std::shared_ptr<LandmarkMap> map_ = std::make_shared<LandmarkMap>();
  std::optional<KeyframePlaces> places_;
  RecoveredMap result_;
};

}  // namespace

RecoveredMap recover_landmark_map(RecoveredRows& rows) { return LandmarkRecovery(rows).run(); }

}  // namespace rastro
