// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmarks/map_scale.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/map/graph/sessions.h"
#include "rastro/map/landmarks/jackknife.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/landmarks/landmark_uncertainty.h"
#include "rastro/map/semi_dense/semi_dense_layer.h"
#include "rastro/math/alignment.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

constexpr TimeNs largest_gap = 1'000'000'000;  ///< Maximum gap between interpolated poses.

Landmark landmark_named(const Map& map, std::int64_t id, const std::string& where) {
  const auto layer = map.layer<LandmarkLayer>();
  const Landmark* found = layer ? layer->find(id) : nullptr;
  if (!found)
    throw Error(fmt::format("the map has no landmark {}", id), where,
                "'rastro export RUN --to landmarks' lists them; frames are written f0,f120,METERS");
  if (found->observations.empty() || submap_of(map, *found) != 0)
    throw Error(fmt::format("landmark {} is in a submap that is not connected to the first one", id), where,
                "take landmarks of submap 0");
  return *found;
}

/// Each recording numbers its frames from 0.
std::vector<Keyframe> keyframes_of_first_session(const Map& map) {
  const auto sessions = sessions_of_keyframes(map);
  std::vector<Keyframe> keyframes;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k)
    if (sessions[k].value_or(0) == 0) keyframes.push_back(map.keyframes[k]);
  return keyframes;
}

/// Interpolates the stamp linearly between the keyframes around a frame.
TimeNs stamp_of_frame(const Map& map, std::int64_t frame, const std::string& where) {
  const std::vector<Keyframe> keyframes = keyframes_of_first_session(map);
  const auto after =
      std::find_if(keyframes.begin(), keyframes.end(), [&](const Keyframe& k) { return k.frame >= frame; });
  if (after != keyframes.end() && after->frame == frame) return after->stamp;
  if (after == keyframes.end() || after == keyframes.begin())
    throw Error(fmt::format("frame {} is not between the first and the last keyframe of the map", frame), where,
                keyframes.empty()
                    ? "the map is empty"
                    : fmt::format("give frames {} to {}", keyframes.front().frame, keyframes.back().frame));
  const Keyframe &a = *(after - 1), &b = *after;
  const double share = static_cast<double>(frame - a.frame) / static_cast<double>(b.frame - a.frame);
  return a.stamp + static_cast<TimeNs>(std::llround(share * static_cast<double>(b.stamp - a.stamp)));
}

Vector3d camera_at(const Map& map, std::int64_t frame, const std::string& where) {
  const auto pose = pose_at(trajectory_of_session(map, 0), stamp_of_frame(map, frame, where), largest_gap);
  if (!pose)
    throw Error(fmt::format("frame {} has no pose", frame), where, "take frames with a pose in trajectory.txt");
  return pose->translation();
}

struct MeasuredLength {
  double units = 0.0, meters = 0.0;
  double variance = 0.0;  ///< Of `units`; 0: unknown.
};

MeasuredLength measured(const Map& map, const KnownLength& length, const std::string& where) {
  MeasuredLength result;
  result.meters = length.meters;
  Vector3d offset;
  if (length.between_frames) {
    offset = camera_at(map, length.to, where) - camera_at(map, length.from, where);
  } else {
    const Landmark from = landmark_named(map, length.from, where);
    const Landmark to = landmark_named(map, length.to, where);
    offset = to.position - from.position;
    const auto a = landmark_covariance(map, from), b = landmark_covariance(map, to);
    const Vector3d along = offset.normalized();
    if (a && b) result.variance = along.dot((*a + *b) * along);
  }
  result.units = offset.norm();
  if (!(result.units > 0.0) || !std::isfinite(result.units))
    throw Error(fmt::format("{} and {} are at the same position", length.from, length.to), where,
                "give two different points");
  return result;
}

}  // namespace

MapScaleFound scale_from_lengths(const Map& map, std::span<const KnownLength> lengths, const std::string& where) {
  RASTRO_CHECK(!lengths.empty(), "there is a length");
  double products = 0.0, squares = 0.0, variance = 0.0;
  std::vector<MeasuredLength> all;
  for (const KnownLength& length : lengths) {
    all.push_back(measured(map, length, where));
    products += all.back().meters * all.back().units;
    squares += all.back().units * all.back().units;
    variance += all.back().variance * all.back().units * all.back().units;
  }
  MapScaleFound found;
  found.meters_per_unit = products / squares;
  found.measurements = static_cast<int>(lengths.size());
  found.from = lengths.size() == 1 ? "a known length" : fmt::format("{} known lengths", lengths.size());
  if (lengths.size() == 1) {
    found.relative_sigma = std::sqrt(variance) / squares;
    return found;
  }
  double rest = 0.0;
  for (const MeasuredLength& length : all) rest += std::pow(length.meters - found.meters_per_unit * length.units, 2);
  const double residual_variance = rest / static_cast<double>(lengths.size() - 1);
  found.relative_sigma = std::sqrt(residual_variance / squares) / found.meters_per_unit;
  return found;
}

namespace {

struct PosesAtOneTime {
  std::vector<SE3> reference, map;
};

PosesAtOneTime poses_at_one_time(const Trajectory& trajectory, const Trajectory& reference, const std::string& where) {
  constexpr std::size_t least_pairs = 10;
  PosesAtOneTime poses;
  for (const StampedPose& pose : trajectory) {
    const auto known = pose_at(reference, pose.stamp, largest_gap);
    if (!known) continue;
    poses.reference.push_back(*known);
    poses.map.push_back(pose.world_from_body);
  }
  if (poses.map.size() < least_pairs)
    throw Error(fmt::format("{} of the map's {} poses lie within the reference, need {}", poses.map.size(),
                            trajectory.size(), least_pairs),
                where, "give a reference with the clock of the recording");
  return poses;
}

/// Without those from begin to end - 1.
std::optional<Sim3> reference_from_map(const PosesAtOneTime& poses, std::size_t begin, std::size_t end) {
  std::vector<Vector3d> to, from;
  for (std::size_t i = 0; i < poses.map.size(); ++i) {
    if (i >= begin && i < end) continue;
    to.push_back(poses.reference[i].translation());
    from.push_back(poses.map[i].translation());
  }
  const auto alignment = align_points(to, from, AlignmentKind::similarity);
  return alignment ? std::optional(alignment->target_from_source) : std::nullopt;
}

double position_misfit(const PosesAtOneTime& poses, const Sim3& reference_from_map) {
  Vector3d mean = Vector3d::Zero();
  for (const SE3& pose : poses.reference) mean += pose.translation() / static_cast<double>(poses.reference.size());
  double off = 0.0, spread = 0.0;
  for (std::size_t i = 0; i < poses.map.size(); ++i) {
    off += (reference_from_map * poses.map[i].translation() - poses.reference[i].translation()).squaredNorm();
    spread += (poses.reference[i].translation() - mean).squaredNorm();
  }
  return std::sqrt(off / spread);
}

/// Angles do not depend on the worlds, nor on how a device that gave the reference is mounted. 0 for a reference that
/// never turns: it is of positions alone.
double turn_misfit_deg(const PosesAtOneTime& poses) {
  constexpr double degrees = 180.0 / std::numbers::pi, least_turn = 1e-6;
  const std::size_t middle = poses.map.size() / 2;
  const auto turned = [middle](const std::vector<SE3>& all, std::size_t i) {
    return (all[middle].rotation().inverse() * all[i].rotation()).log().norm();
  };
  double squares = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < poses.map.size(); ++i) {
    const double of_reference = turned(poses.reference, i);
    largest = std::max(largest, of_reference);
    squares += std::pow(of_reference - turned(poses.map, i), 2);
  }
  return largest > least_turn ? degrees * std::sqrt(squares / static_cast<double>(poses.map.size())) : 0.0;
}

}  // namespace

Trajectory trajectory_for_reference(const Map& map, std::optional<std::size_t> session, const std::string& where) {
  if (!sessions_overlap(map)) return trajectory_of(map);
  if (!session)
    throw Error("is of the recording of no session, and the sessions of the map overlap in time", where,
                "give one of the recordings that 'rastro info' lists, or a file in its folder");
  return trajectory_of_session(map, *session);
}

MapScaleFound scale_from_reference(const Map& map, const Trajectory& reference, const std::string& where,
                                   std::optional<std::size_t> session) {
  const PosesAtOneTime poses = poses_at_one_time(trajectory_for_reference(map, session, where), reference, where);
  const auto whole = reference_from_map(poses, 0, 0);
  if (!whole) throw Error("the camera or the reference does not move", where, "give a reference of a moving camera");
  const auto scale_without = [&](std::size_t begin, std::size_t end) -> std::optional<double> {
    const auto part = reference_from_map(poses, begin, end);
    return part ? std::optional(part->scale()) : std::nullopt;
  };
  MapScaleFound found;
  found.meters_per_unit = whole->scale();
  found.relative_sigma = jackknife_sigma(poses.map.size(), scale_without) / whole->scale();
  found.measurements = static_cast<int>(poses.map.size());
  found.from = "a reference trajectory";
  found.position_misfit = position_misfit(poses, *whole);
  found.turn_misfit_deg = turn_misfit_deg(poses);
  return found;
}

namespace {

std::shared_ptr<const SemiDenseDepth> scaled(const SemiDenseDepth& depth, double factor) {
  auto result = std::make_shared<SemiDenseDepth>(depth);
  const auto inverse = static_cast<float>(1.0 / factor);
  for (SemiDenseDepth::Pixel& pixel : result->pixels)
    pixel.inverse_depth *= inverse, pixel.variance *= inverse * inverse;
  return result;
}

Constraint scaled(const Constraint& constraint, double factor) {
  const Sim3& pose = constraint.from_from_to;
  Constraint result = constraint;
  result.from_from_to = Sim3(pose.scale(), pose.rotation(), factor * pose.translation());
  if (constraint.information.isIdentity()) return result;  // of a method that does not tell it
  result.information.topLeftCorner<3, 3>() /= factor * factor;
  result.information.topRightCorner<3, 3>() /= factor;
  result.information.bottomLeftCorner<3, 3>() /= factor;
  return result;
}

}  // namespace

Vector3d fixed_point_of(const Map& map) {
  return map.keyframes.empty() ? Vector3d(Vector3d::Zero()) : map.keyframes.front().world_from_camera.translation();
}

Map scaled(const Map& map, const MapScaleFound& found) {
  RASTRO_CHECK(!scale_of(map).metric || map.cameras.empty() || map.cameras.front().kind == CameraKind::mono,
               "only the map of one camera has a unit that can be chosen");
  const double factor = found.meters_per_unit;
  RASTRO_CHECK(factor > 0.0 && std::isfinite(factor), "a scale is positive");
  const auto stretched = [factor](const SE3& pose) { return SE3(pose.rotation(), factor * pose.translation()); };
  // A position that was given, as with --initial-pose, is in meters: only what lies around it has the map's unit.
  const Vector3d fixed = fixed_point_of(map);
  const auto moved = [&](const Vector3d& position) { return Vector3d(fixed + factor * (position - fixed)); };
  Map result = map;
  ++result.revision;
  for (Keyframe& keyframe : result.keyframes)
    keyframe.world_from_camera =
        SE3(keyframe.world_from_camera.rotation(), moved(keyframe.world_from_camera.translation()));
  for (MapFrame& frame : result.frames) frame.keyframe_from_camera = stretched(frame.keyframe_from_camera);
  for (Constraint& each : result.constraints) each = scaled(each, factor);
  for (MapSession& session : result.sessions) session.scale = {true, found.relative_sigma, found.from};
  if (const auto semi_dense = map.layer<SemiDenseLayer>()) {
    auto depths = std::make_shared<SemiDenseLayer>();
    for (const auto& [id, depth] : semi_dense->of) depths->of[id] = scaled(*depth, factor);
    result.layers.put<SemiDenseLayer>(std::move(depths));
  }
  const auto layer = map.layer<LandmarkLayer>();
  if (!layer) return result;
  auto landmarks = std::make_shared<LandmarkLayer>(*layer);
  for (Landmark& landmark : landmarks->landmarks) {
    landmark.position = moved(landmark.position);
    landmark.min_distance = static_cast<float>(factor * landmark.min_distance);
    landmark.max_distance = static_cast<float>(factor * landmark.max_distance);
  }
  result.layers.put<LandmarkLayer>(std::move(landmarks));
  return result;
}

}  // namespace rastro
