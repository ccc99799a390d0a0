// SPDX-License-Identifier: Apache-2.0
#include "rastro/map/landmark/map_scale.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "rastro/base/error.h"
#include "rastro/map/landmark/jackknife.h"
#include "rastro/map/landmark/keyframe_places.h"
#include "rastro/math/alignment.h"

namespace rastro {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr TimeNs largest_gap = 1'000'000'000;  ///< Between poses that are interpolated.

const Landmark& landmark_named(const LandmarkMap& map, std::int64_t id, const std::string& where) {
  const auto found =
      std::lower_bound(map.landmarks.begin(), map.landmarks.end(), id,
                       [](const Landmark& landmark, std::int64_t wanted) { return landmark.id < wanted; });
  if (found == map.landmarks.end() || found->id != id)
    throw Error(fmt::format("the map has no landmark {}", id), where,
                "'rastro export RUN --to landmarks' lists them; frames are written f0,f120,METRES");
  const auto viewer =
      found->observations.empty() ? std::nullopt : KeyframePlaces(map).of(found->observations.front().keyframe);
  if (!viewer || map.poses[*viewer].submap != 0)
    throw Error(fmt::format("landmark {} is in a part of the map that nothing ties to the first one", id), where,
                "take landmarks of submap 0");
  return *found;
}

/// Stamps run evenly between the keyframes around a frame.
TimeNs stamp_of_frame(const LandmarkMap& map, std::int64_t frame, const std::string& where) {
  const auto& keyframes = map.keyframes;
  const auto after = std::find_if(keyframes.begin(), keyframes.end(), [&](const auto& k) { return k->frame >= frame; });
  if (after != keyframes.end() && (*after)->frame == frame) return (*after)->stamp;
  if (after == keyframes.end() || after == keyframes.begin())
    throw Error(fmt::format("frame {} is not between the first and the last keyframe of the map", frame), where,
                keyframes.empty()
                    ? "the map is empty"
                    : fmt::format("give frames {} to {}", keyframes.front()->frame, keyframes.back()->frame));
  const LandmarkKeyframe &a = **(after - 1), &b = **after;
  const double share = static_cast<double>(frame - a.frame) / static_cast<double>(b.frame - a.frame);
  return a.stamp + static_cast<TimeNs>(std::llround(share * static_cast<double>(b.stamp - a.stamp)));
}

Vector3d camera_at(const LandmarkMap& map, std::int64_t frame, const std::string& where) {
  const auto pose = pose_at(map.trajectory, stamp_of_frame(map, frame, where), largest_gap);
  if (!pose)
    throw Error(fmt::format("frame {} has no pose", frame), where, "take frames with a pose in trajectory.txt");
  return pose->translation();
}

struct MeasuredLength {
  double units = 0.0, metres = 0.0;
  double variance = 0.0;  ///< Of `units`; 0: not known.
};

MeasuredLength measured(const LandmarkMap& map, const KnownLength& length, const std::string& where) {
  MeasuredLength result;
  result.metres = length.metres;
  Vector3d apart;
  if (length.between_frames) {
    apart = camera_at(map, length.to, where) - camera_at(map, length.from, where);
  } else {
    const Landmark& from = landmark_named(map, length.from, where);
    const Landmark& to = landmark_named(map, length.to, where);
    apart = to.position - from.position;
    const auto a = place_covariance(map, from), b = place_covariance(map, to);
    const Vector3d along = apart.normalized();
    if (a && b) result.variance = along.dot((*a + *b) * along);
  }
  result.units = apart.norm();
  if (!(result.units > 0.0) || !std::isfinite(result.units))
    throw Error(fmt::format("{} and {} are at the same place", length.from, length.to), where, "give two places apart");
  return result;
}

}  // namespace

std::optional<Matrix3d> place_covariance(const LandmarkMap& map, const Landmark& landmark) {
  constexpr double least_condition = 1e-9;
  const KeyframePlaces places(map);
  const std::vector<double> scales = orb_level_scales(map.features);
  Matrix3d information = Matrix3d::Zero();
  for (const LandmarkObservation& observation : landmark.observations) {
    const auto k = places.of(observation.keyframe);
    if (!k) continue;
    const SE3 camera_from_world = map.poses[*k].world_from_camera.inverse();
    Eigen::Matrix<double, 2, 3> by_point;
    if (!map.camera.project(camera_from_world * landmark.position, by_point)) continue;
    const Eigen::Matrix<double, 2, 3> by_place = by_point * camera_from_world.rotation().matrix() /
                                                 scales[map.keyframes[*k]->features.levels[observation.feature]];
    information += by_place.transpose() * by_place;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(information);
  const Vector3d& values = solver.eigenvalues();
  if (!(values[0] > least_condition * values[2])) return std::nullopt;
  return Matrix3d(information.inverse());
}

MapScaleFound scale_from_lengths(const LandmarkMap& map, std::span<const KnownLength> lengths,
                                 const std::string& where) {
  RASTRO_CHECK(!lengths.empty(), "there is a length");
  double products = 0.0, squares = 0.0, variance = 0.0;
  std::vector<MeasuredLength> all;
  for (const KnownLength& length : lengths) {
    all.push_back(measured(map, length, where));
    products += all.back().metres * all.back().units;
    squares += all.back().units * all.back().units;
    variance += all.back().variance * all.back().units * all.back().units;
  }
  MapScaleFound found;
  found.metres_per_unit = products / squares;
  found.measurements = static_cast<int>(lengths.size());
  found.from = lengths.size() == 1 ? "a known length" : fmt::format("{} known lengths", lengths.size());
  if (lengths.size() == 1) {
    found.relative_sigma = std::sqrt(variance) / squares;
    return found;
  }
  double rest = 0.0;
  for (const MeasuredLength& length : all) rest += std::pow(length.metres - found.metres_per_unit * length.units, 2);
  const double residual_variance = rest / static_cast<double>(lengths.size() - 1);
  found.relative_sigma = std::sqrt(residual_variance / squares) / found.metres_per_unit;
  return found;
}

MapScaleFound scale_from_reference(const LandmarkMap& map, const Trajectory& reference, const std::string& where) {
  constexpr std::size_t least_pairs = 10;
  std::vector<Vector3d> target, source;
  for (const StampedPose& pose : map.trajectory) {
    const auto known = pose_at(reference, pose.stamp, largest_gap);
    if (!known) continue;
    target.push_back(known->translation());
    source.push_back(pose.world_from_body.translation());
  }
  if (source.size() < least_pairs)
    throw Error(fmt::format("{} of the map's {} poses lie within the reference, need {}", source.size(),
                            map.trajectory.size(), least_pairs),
                where, "give a reference with the clock of the recording");
  const auto scale_without = [&](std::size_t begin, std::size_t end) -> std::optional<double> {
    std::vector<Vector3d> to, from;
    for (std::size_t i = 0; i < source.size(); ++i) {
      if (i >= begin && i < end) continue;
      to.push_back(target[i]);
      from.push_back(source[i]);
    }
    const auto alignment = align_points(to, from, AlignmentKind::similarity);
    return alignment ? std::optional(alignment->target_from_source.scale()) : std::nullopt;
  };
  const auto whole = scale_without(0, 0);
  if (!whole) throw Error("the camera or the reference does not move", where, "give a reference of a moving camera");
  MapScaleFound found;
  found.metres_per_unit = *whole;
  found.relative_sigma = jackknife_sigma(source.size(), scale_without) / *whole;
  found.measurements = static_cast<int>(source.size());
  found.from = "a reference trajectory";
  return found;
}

LandmarkMap scaled(const LandmarkMap& map, const MapScaleFound& found) {
  RASTRO_CHECK(map.sensor == LandmarkSensor::mono, "only the map of one camera has a unit that can be chosen");
  const double factor = found.metres_per_unit;
  RASTRO_CHECK(factor > 0.0 && std::isfinite(factor), "a scale is positive");
  const auto stretched = [factor](const SE3& pose) { return SE3(pose.rotation(), factor * pose.translation()); };
  LandmarkMap result = map;
  for (LandmarkKeyframePose& pose : result.poses) pose.world_from_camera = stretched(pose.world_from_camera);
  for (StampedPose& pose : result.trajectory) pose.world_from_body = stretched(pose.world_from_body);
  for (Landmark& landmark : result.landmarks) {
    landmark.position *= factor;
    landmark.min_distance = static_cast<float>(factor * landmark.min_distance);
    landmark.max_distance = static_cast<float>(factor * landmark.max_distance);
  }
  for (LandmarkTie& tie : result.ties)
    tie.from_from_to =
        Sim3(tie.from_from_to.scale(), tie.from_from_to.rotation(), factor * tie.from_from_to.translation());
  result.scale = {true, found.relative_sigma, found.from};
  return result;
}

}  // namespace rastro
