// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/file/landmark_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "rastro/base/error.h"
#include "rastro/map/file/bytes.h"
#include "rastro/map/file/contents.h"
#include "rastro/map/file/landmark_rows.h"
#include "rastro/map/landmark/landmark_checks.h"

namespace rastro {
namespace {

bool same(const SE3& a, const SE3& b) {
  return a.translation() == b.translation() && a.rotation().quaternion().coeffs() == b.rotation().quaternion().coeffs();
}

bool same(const LandmarkKeyframePose& a, const LandmarkKeyframePose& b) {
  return a.submap == b.submap && a.parent == b.parent && same(a.world_from_camera, b.world_from_camera);
}

bool same(const Landmark& a, const Landmark& b) {
  return a.position == b.position && a.direction == b.direction && a.descriptor == b.descriptor &&
         a.min_distance == b.min_distance && a.max_distance == b.max_distance && a.observations == b.observations;
}

bool same(const StampedPose& a, const StampedPose& b) {
  return a.stamp == b.stamp && same(a.world_from_body, b.world_from_body);
}

bool same(const LandmarkTie& a, const LandmarkTie& b) {
  return a.from == b.from && a.to == b.to && a.inliers == b.inliers &&
         a.from_from_to.matrix() == b.from_from_to.matrix();
}

/// Walks two lists in the order of their ids, handing on what is gone and pairs of places (before: -1 where new).
template <typename IdBefore, typename IdNow, typename Gone, typename Pair>
void compare_by_id(std::size_t count_before, std::size_t count_now, IdBefore id_before, IdNow id_now, Gone gone,
                   Pair pair) {
  std::size_t before = 0;
  for (std::size_t now = 0; now < count_now; ++now) {
    for (; before < count_before && id_before(before) < id_now(now); ++before) gone(id_before(before));
    const bool known = before < count_before && id_before(before) == id_now(now);
    pair(known ? static_cast<std::ptrdiff_t>(before) : -1, now);
    if (known) ++before;
  }
  for (; before < count_before; ++before) gone(id_before(before));
}

template <typename Row>
void write_list(MapTable table, const std::vector<Row>& before, const std::vector<Row>& now, Database& database) {
  for (std::size_t i = 0; i < now.size(); ++i)
    if (i >= before.size() || !same(before[i], now[i]))
      database.put(table, static_cast<std::int64_t>(i), body_of(now[i]));
  for (std::size_t i = now.size(); i < before.size(); ++i) database.remove(table, static_cast<std::int64_t>(i));
}

void write_keyframes(const LandmarkMap& before, const LandmarkMap& now, Database& database) {
  for (const MapTable table : {MapTable::keyframes, MapTable::poses}) {
    compare_by_id(
        before.keyframes.size(), now.keyframes.size(), [&](std::size_t i) { return before.keyframes[i]->id; },
        [&](std::size_t i) { return now.keyframes[i]->id; }, [&](std::int64_t id) { database.remove(table, id); },
        [&](std::ptrdiff_t known, std::size_t i) {
          const auto k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(known, 0));
          const std::int64_t id = now.keyframes[i]->id;
          if (table == MapTable::keyframes) {
            if (known < 0 || before.keyframes[k] != now.keyframes[i])
              database.put(table, id, body_of(*now.keyframes[i]));
          } else if (known < 0 || !same(before.poses[k], now.poses[i])) {
            database.put(table, id, body_of(now.poses[i]));
          }
        });
  }
}

void write_landmarks(const LandmarkMap& before, const LandmarkMap& now, Database& database) {
  compare_by_id(
      before.landmarks.size(), now.landmarks.size(), [&](std::size_t i) { return before.landmarks[i].id; },
      [&](std::size_t i) { return now.landmarks[i].id; },
      [&](std::int64_t id) { database.remove(MapTable::landmarks, id); },
      [&](std::ptrdiff_t known, std::size_t i) {
        const Landmark& landmark = now.landmarks[i];
        if (known < 0 || !same(before.landmarks[static_cast<std::size_t>(known)], landmark))
          database.put(MapTable::landmarks, landmark.id, body_of(landmark));
      });
}

template <typename Read>
void read_rows(const Database& database, MapTable table, Read read) {
  for (RowReader rows(database, table); rows.next();) read(rows.body(), rows.id(), rows.where());
}

/// Rows of a list are numbered without a gap.
void check_place(const Database& database, MapTable table, std::int64_t id, std::size_t place) {
  if (id != static_cast<std::int64_t>(place))
    refuse_damaged(database.file(), fmt::format("lacks row {} of {}", place, name_of(table)));
}

void read_keyframes(const Database& database, LandmarkMap& map) {
  read_rows(database, MapTable::keyframes, [&](std::string_view body, std::int64_t id, const std::string& where) {
    map.keyframes.push_back(read_landmark_keyframe(body, id, where));
  });
  read_rows(database, MapTable::poses, [&](std::string_view body, std::int64_t id, const std::string& where) {
    const std::size_t place = map.poses.size();
    if (place >= map.keyframes.size() || map.keyframes[place]->id != id)
      refuse_damaged(database.file(), "does not have a pose for every keyframe");
    map.poses.push_back(read_landmark_keyframe_pose(body, where));
  });
}

void read_lists(const Database& database, LandmarkMap& map) {
  read_rows(database, MapTable::landmarks, [&](std::string_view body, std::int64_t id, const std::string& where) {
    map.landmarks.push_back(read_landmark(body, id, where));
  });
  read_rows(database, MapTable::ties, [&](std::string_view body, std::int64_t id, const std::string& where) {
    check_place(database, MapTable::ties, id, map.ties.size());
    map.ties.push_back(read_tie(body, where));
  });
  read_rows(database, MapTable::way, [&](std::string_view body, std::int64_t id, const std::string& where) {
    check_place(database, MapTable::way, id, map.trajectory.size());
    map.trajectory.push_back(read_stamped_pose(body, where));
  });
}

}  // namespace

void write_changes(const LandmarkMap* before, const LandmarkMap& now, Database& database) {
  RASTRO_CHECK(now.poses.size() == now.keyframes.size(), "every keyframe has a pose");
  const LandmarkMap nothing;
  const std::string head = head_body(now);
  if (!before || head_body(*before) != head) {
    database.put(MapTable::head, 0, head);
    database.put(MapTable::contents, second_head_row, head);
  }
  const LandmarkMap& former = before ? *before : nothing;
  write_keyframes(former, now, database);
  write_landmarks(former, now, database);
  write_list(MapTable::ties, former.ties, now.ties, database);
  write_list(MapTable::way, former.trajectory, now.trajectory, database);
}

LandmarkMap read_landmark_map(const Database& database) {
  LandmarkMap map;
  const auto head = row_of(database, MapTable::head, 0);
  if (!head) refuse_damaged(database.file());
  read_head(*head, database.file(), map);
  read_keyframes(database, map);
  read_lists(database, map);
  const std::string fault = contradiction_in(map);
  if (!fault.empty()) refuse_damaged(database.file(), fault);
  return map;
}

}  // namespace rastro
