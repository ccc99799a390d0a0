// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/map/graph/sessions.h"
#include "rastro/map/landmarks/jackknife.h"
#include "rastro/map/landmarks/landmark_layer.h"
#include "rastro/map/landmarks/map_scale.h"

namespace rastro {
namespace {

using Eigen::Vector3d;

// The region in which a keyframe's landmarks may be ground, in camera heights.
constexpr double most_ahead = 12.0, least_ahead = 0.5, most_beside = 2.0;
constexpr double least_cos_ahead = 0.7;  ///< Between viewing direction and direction of travel.
constexpr double kernel = 0.06;          ///< Of the logarithm of a height: 6 %.
constexpr std::size_t least_points = 50;
constexpr double least_share = 0.15;  ///< Of the candidates, within two kernels of the height found.

/// How far below its camera a landmark lies, and the weight of that.
struct Depression {
  double log_height = 0.0, weight = 0.0;
};

/// Down is perpendicular to the trajectory and to the camera's x axis, so that a camera may be pitched.
std::optional<Vector3d> down_at(const Map& map, std::size_t before, std::size_t here, std::size_t after) {
  const Vector3d motion =
      map.keyframes[after].world_from_camera.translation() - map.keyframes[before].world_from_camera.translation();
  if (!(motion.norm() > 0.0)) return std::nullopt;
  const Eigen::Matrix3d axes = map.keyframes[here].world_from_camera.rotation().matrix();
  const double cosine = motion.normalized().dot(axes.col(2));
  if (std::abs(cosine) < least_cos_ahead) return std::nullopt;
  return Vector3d((cosine < 0.0 ? -1.0 : 1.0) * motion.cross(axes.col(0)).normalized());
}

void add_depressions(const Map& map, const std::vector<Landmark>& landmarks, std::size_t k, const Vector3d& down,
                     const std::vector<std::uint32_t>& seen, std::vector<Depression>& depressions) {
  const SE3& world_from_camera = map.keyframes[k].world_from_camera;
  const Vector3d right = world_from_camera.rotation() * Vector3d::UnitX();
  const Vector3d ahead = right.cross(down);
  for (const std::uint32_t i : seen) {
    const Vector3d away = landmarks[i].position - world_from_camera.translation();
    const double height = down.dot(away), forward = ahead.dot(away);
    if (!(height > 0.0) || forward < least_ahead * height || forward > most_ahead * height) continue;
    if (std::abs(right.dot(away)) > most_beside * height) continue;
    depressions.push_back({std::log(height), height / forward});  // a tilt has more effect on distant points
  }
}

double support(const std::vector<Depression>& depressions, double at, double width) {
  double sum = 0.0;
  for (const Depression& each : depressions) {
    const double off = (each.log_height - at) / width;
    if (std::abs(off) < 3.0) sum += each.weight * std::exp(-0.5 * off * off);
  }
  return sum;
}

/// The mode: the best of a grid, then moved to the mean of the nearby values.
std::optional<double> mode_of(const std::vector<Depression>& depressions) {
  constexpr int steps = 400, rounds = 20;
  if (depressions.size() < least_points) return std::nullopt;
  const auto [lowest, highest] =
      std::minmax_element(depressions.begin(), depressions.end(),
                          [](const Depression& a, const Depression& b) { return a.log_height < b.log_height; });
  double best = lowest->log_height, most = -1.0;
  for (int i = 0; i <= steps; ++i) {
    const double at = lowest->log_height + (highest->log_height - lowest->log_height) * i / steps;
    const double sum = support(depressions, at, kernel);
    if (sum > most) most = sum, best = at;
  }
  for (int round = 0; round < rounds; ++round) {
    double sum = 0.0, moment = 0.0;
    for (const Depression& each : depressions) {
      const double off = (each.log_height - best) / kernel;
      if (std::abs(off) > 3.0) continue;
      const double weight = each.weight * std::exp(-0.5 * off * off);
      sum += weight;
      moment += weight * each.log_height;
    }
    best = moment / sum;
  }
  return best;
}

/// Keyframes of submap 0 in the order of their frames, by session: each recording numbers its frames from 0.
std::vector<std::vector<std::size_t>> paths_of(const Map& map) {
  const auto sessions = sessions_of_keyframes(map);
  std::map<std::optional<std::size_t>, std::vector<std::size_t>> by_session;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k)
    if (map.keyframes[k].submap == 0) by_session[sessions[k]].push_back(k);
  std::vector<std::vector<std::size_t>> paths;
  for (auto& [session, path] : by_session) {
    std::stable_sort(path.begin(), path.end(),
                     [&](std::size_t a, std::size_t b) { return map.keyframes[a].frame < map.keyframes[b].frame; });
    paths.push_back(std::move(path));
  }
  return paths;
}

/// By keyframe, session by session; empty for those that do not face their direction of travel.
std::vector<std::vector<Depression>> depressions_of(const Map& map) {
  const auto layer = map.layer<LandmarkLayer>();
  if (!layer) return {};
  const std::vector<Landmark>& landmarks = layer->landmarks;
  std::vector<std::vector<std::uint32_t>> seen(map.keyframes.size());
  for (std::size_t i = 0; i < landmarks.size(); ++i)
    for (const LandmarkObservation& observation : landmarks[i].observations)
      if (const auto k = map.index_of(observation.keyframe)) seen[*k].push_back(static_cast<std::uint32_t>(i));
  std::vector<std::vector<Depression>> depressions;
  for (const std::vector<std::size_t>& path : paths_of(map))
    for (std::size_t i = 0; i < path.size(); ++i) {
      const auto down = down_at(map, path[i > 0 ? i - 1 : 0], path[i], path[std::min(i + 1, path.size() - 1)]);
      std::vector<Depression>& of_keyframe = depressions.emplace_back();
      if (down) add_depressions(map, landmarks, path[i], *down, seen[path[i]], of_keyframe);
    }
  return depressions;
}

}  // namespace

MapScaleFound scale_from_camera_height(const Map& map, double height_m, const std::string& where) {
  const auto depressions = depressions_of(map);
  const auto without = [&](std::size_t begin, std::size_t end) {
    std::vector<Depression> left;
    for (std::size_t k = 0; k < depressions.size(); ++k)
      if (k < begin || k >= end) left.insert(left.end(), depressions[k].begin(), depressions[k].end());
    return left;
  };
  const auto height_without = [&](std::size_t begin, std::size_t end) -> std::optional<double> {
    const auto mode = mode_of(without(begin, end));
    return mode ? std::optional(std::exp(*mode)) : std::nullopt;
  };
  const std::vector<Depression> all = without(0, 0);
  const auto mode = mode_of(all);
  const auto near =
      mode ? std::count_if(all.begin(), all.end(),
                           [&](const Depression& each) { return std::abs(each.log_height - *mode) < 2.0 * kernel; })
           : 0;
  if (!mode || static_cast<double>(near) < least_share * static_cast<double>(all.size()))
    throw Error(
        fmt::format("no flat ground is seen ahead of the camera ({} observations of landmarks below it)", all.size()),
        where, "give --length or --reference");
  MapScaleFound found;
  found.meters_per_unit = height_m / std::exp(*mode);
  found.relative_sigma = jackknife_sigma(depressions.size(), height_without) / std::exp(*mode);
  found.measurements = static_cast<int>(near);
  found.from = fmt::format("a camera height of {:g} m", height_m);
  return found;
}

}  // namespace rastro
