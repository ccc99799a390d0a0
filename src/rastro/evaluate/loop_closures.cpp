// SPDX-License-Identifier: Apache-2.0
#include "rastro/evaluate/loop_closures.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>

#include "rastro/base/error.h"
#include "rastro/math/alignment.h"

namespace rastro {
namespace {

constexpr const char* closures_form = "give the closures.yaml of a generated recording";

TimeNs stamp_in(const YAML::Node& entry, const char* key, const std::string& where) {
  const YAML::Node value = entry[key];
  std::int64_t stamp = 0;
  if (!value || !value.IsScalar() || !YAML::convert<std::int64_t>::decode(value, stamp))
    throw Error(fmt::format("no time in nanoseconds at '{}'", key), fmt::format("{}:{}", where, entry.Mark().line + 1),
                closures_form);
  return stamp;
}

YAML::Node list_in(const std::string& text, const std::string& where) {
  try {
    const YAML::Node root = YAML::Load(text);
    if (root.IsMap() && root["closures"] && (root["closures"].IsSequence() || root["closures"].IsNull()))
      return root["closures"];
  } catch (const YAML::Exception& error) {
    throw Error("is not YAML", fmt::format("{}:{}", where, error.mark.line + 1), closures_form);
  }
  throw Error("has no list 'closures'", where, closures_form);
}

double degrees_of(const SE3& pose) { return pose.rotation().log().norm() * 180.0 / std::numbers::pi; }

/// A later frame relative to an earlier one, as the map holds it.
struct Link {
  TimeNs stamp = 0, earlier_stamp = 0;
  SE3 earlier_from_later;  ///< Of the body.
};

/// Of a map up to scale, by its keyframes in submap 0; 1 where they do not tell.
double meters_per_unit(const Map& map, const Trajectory& ground_truth, TimeNs max_gap) {
  if (map.sessions.empty() || scale_of(map).metric) return 1.0;
  std::vector<Eigen::Vector3d> expected, found;
  for (const Keyframe& keyframe : map.keyframes) {
    const auto pose = pose_at(ground_truth, keyframe.stamp, max_gap);
    if (!pose || keyframe.submap != 0) continue;
    expected.push_back(pose->translation());
    found.push_back(keyframe.world_from_camera.translation());
  }
  const auto aligned = align_points(expected, found, AlignmentKind::similarity);
  return aligned ? aligned->target_from_source.scale() : 1.0;
}

class Scoring {
 public:
  Scoring(const Map& map, const Trajectory& ground_truth, const LoopClosureLimits& limits)
      : map_(map),
        ground_truth_(ground_truth),
        limits_(limits),
        max_gap_(from_seconds(limits.max_ground_truth_gap_s)),
        meters_per_unit_(meters_per_unit(map, ground_truth, max_gap_)) {}

  LoopClosureScores score(const std::vector<Revisit>& revisits) {
    add_constraints();
    add_frames();
    std::sort(closed_.begin(), closed_.end());
    scores_.revisits = static_cast<std::int64_t>(revisits.size());
    std::copy_if(revisits.begin(), revisits.end(), std::back_inserter(scores_.missed),
                 [this](const Revisit& revisit) { return !is_closed(revisit.stamp); });
    scores_.found = scores_.revisits - static_cast<std::int64_t>(scores_.missed.size());
    return scores_;
  }

 private:
  SE3 of_body(const Keyframe& keyframe, const SE3& a_from_b) const {
    if (map_.cameras.empty()) return a_from_b;
    const SE3& body_from_camera = map_.cameras[static_cast<std::size_t>(keyframe.camera)].body_from_camera;
    return body_from_camera * a_from_b * body_from_camera.inverse();
  }

  std::optional<Link> link_of(TimeNs earlier, TimeNs later, const SE3& earlier_from_later) const {
    const bool swapped = later < earlier;
    Link link = swapped ? Link{earlier, later, earlier_from_later.inverse()} : Link{later, earlier, earlier_from_later};
    return to_seconds(link.stamp - link.earlier_stamp) >= limits_.gap_s ? std::optional(link) : std::nullopt;
  }

  /// measured.inverse() * true; nullopt: without ground truth.
  std::optional<SE3> error_of(const Link& link) const {
    const auto earlier = pose_at(ground_truth_, link.earlier_stamp, max_gap_),
               later = pose_at(ground_truth_, link.stamp, max_gap_);
    if (!earlier || !later) return std::nullopt;
    const SE3 measured(link.earlier_from_later.rotation(), meters_per_unit_ * link.earlier_from_later.translation());
    return measured.inverse() * (earlier->inverse() * *later);
  }

  bool is_small(const SE3& error) const {
    return error.translation().norm() <= limits_.max_error_m && degrees_of(error) <= limits_.max_error_deg;
  }

  bool is_right(const Link& link) const {
    const auto error = error_of(link);
    return error && is_small(*error);
  }

  void add_constraints() {
    for (const Constraint& constraint : map_.constraints) {
      const Keyframe &from = *map_.find(constraint.from), &to = *map_.find(constraint.to);
      const auto link = link_of(from.stamp, to.stamp, of_body(from, constraint.rigid()));
      if (!link) continue;
      const auto error = error_of(*link);
      if (!error) {
        ++scores_.unknown;
        continue;
      }
      ++scores_.accepted;
      if (!is_small(*error)) {
        ++scores_.wrong;
        scores_.wrong_ones.push_back({from.id, to.id, link->stamp, link->earlier_stamp, constraint.kind,
                                      error->translation().norm(), degrees_of(*error)});
        continue;
      }
      closed_.push_back(link->stamp);
      closing_.emplace(link->stamp == to.stamp ? to.id : from.id, *link);
    }
  }

  /// A frame is placed in a keyframe, of an earlier visit or one that closes a loop with such.
  void add_frames() {
    for (const MapFrame& frame : map_.frames) {
      const Keyframe& keyframe = *map_.find(frame.keyframe);
      if (frame.stamp <= keyframe.stamp) continue;
      const Link link{frame.stamp, keyframe.stamp, of_body(keyframe, frame.keyframe_from_camera)};
      const bool is_of_earlier_visit = to_seconds(link.stamp - link.earlier_stamp) >= limits_.gap_s;
      if (is_of_earlier_visit ? is_right(link) : is_closed_by(keyframe.id, link)) closed_.push_back(frame.stamp);
    }
  }

  /// True over both parts: from the earlier visit to the keyframe, and from there to the frame.
  bool is_closed_by(KeyframeId keyframe, const Link& to_frame) const {
    const auto [first, last] = closing_.equal_range(keyframe);
    return std::any_of(first, last, [&](const auto& each) {
      const Link& closing = each.second;
      return is_right(
          {to_frame.stamp, closing.earlier_stamp, closing.earlier_from_later * to_frame.earlier_from_later});
    });
  }

  bool is_closed(TimeNs stamp) const {
    const TimeNs reach = from_seconds(limits_.max_dt_s);
    const auto first = std::lower_bound(closed_.begin(), closed_.end(), stamp - reach);
    return first != closed_.end() && *first <= stamp + reach;
  }

  const Map& map_;
  const Trajectory& ground_truth_;
  LoopClosureLimits limits_;
  TimeNs max_gap_;
  double meters_per_unit_;
  LoopClosureScores scores_;
  std::vector<TimeNs> closed_;
  std::multimap<KeyframeId, Link> closing_;  ///< Right ones, by the later keyframe.
};

}  // namespace

std::vector<Revisit> parse_revisits(const std::string& text, const std::string& where) {
  std::vector<Revisit> revisits;
  for (const YAML::Node& entry : list_in(text, where)) {
    if (!entry.IsMap())
      throw Error("is not a closure", fmt::format("{}:{}", where, entry.Mark().line + 1), closures_form);
    revisits.push_back({stamp_in(entry, "stamp", where), stamp_in(entry, "earlier_stamp", where)});
  }
  return revisits;
}

Trajectory camera_ground_truth(const SourceInfo& info) {
  Trajectory poses = info.ground_truth;
  if (info.ground_truth_frame != "body" || info.cameras.empty()) return poses;
  const SE3 body_from_camera = info.cameras.front().body_from_camera.value_or(SE3());
  for (StampedPose& pose : poses) pose.world_from_body = pose.world_from_body * body_from_camera;
  return poses;
}

LoopClosureScores score_loop_closures(const Map& map, const std::vector<Revisit>& revisits,
                                      const Trajectory& ground_truth, const LoopClosureLimits& limits) {
  return Scoring(map, ground_truth, limits).score(revisits);
}

}  // namespace rastro
