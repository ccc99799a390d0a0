// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/feature/hamming.h"
#include "rastro/math/so3.h"
#include "rastro/multiview/triangulation.h"
#include "rastro/slam/orb/local_mapping/local_mapping.h"
#include "rastro/slam/orb/local_mapping/near_line.h"
#include "rastro/slam/orb/map/landmark_search.h"

namespace rastro {
namespace {

/// Features of a keyframe without a landmark, as a structure of arrays.
struct FreeFeatures {
  std::vector<float> x, y, limit;  ///< Normalized; squared distance from an epipolar line.
  std::vector<std::uint32_t> features;
};

FreeFeatures free_features(const MapGraph& graph, const MapKeyframe& keyframe, double chi2, double pixel_sigma) {
  FreeFeatures free;
  for (std::uint32_t i = 0; i < keyframe.landmarks.size(); ++i) {
    if (keyframe.landmarks[i] >= 0 || !keyframe.frame->pixel(i).allFinite()) continue;
    const Eigen::Vector2d ray = keyframe.frame->ray(i);
    const double sigma = pixel_sigma * graph.sigma(*keyframe.frame, i);
    free.x.push_back(static_cast<float>(ray.x()));
    free.y.push_back(static_cast<float>(ray.y()));
    free.limit.push_back(static_cast<float>(chi2 * sigma * sigma));
    free.features.push_back(i);
  }
  return free;
}

/// Indices into `free` of the features near the line a x + b y + c = 0.
void near_line(const FreeFeatures& free, const Eigen::Vector3d& line, std::vector<std::uint32_t>& found) {
  found.clear();
  const double norm = line.head<2>().norm();
  if (!(norm > 0.0)) return;
  const Eigen::Vector3f unit = (line / norm).cast<float>();
  find_near_line(free.x, free.y, free.limit, unit.x(), unit.y(), unit.z(), found);
}

struct KeyframePair {
  KeyframePair(const MapKeyframe& first_keyframe, const MapKeyframe& second_keyframe)
      : first(first_keyframe),
        second(second_keyframe),
        second_from_first(second.camera_from_world * first.camera_from_world.inverse()),
        world_from_first(first.camera_from_world.inverse()) {}

  const MapKeyframe& first;
  const MapKeyframe& second;
  SE3 second_from_first, world_from_first;
};

struct EpipolarMatch {
  std::uint32_t first = 0, second = 0;
  int distance = 257;
};

std::vector<EpipolarMatch> epipolar_matches(const KeyframePair& pair, const FreeFeatures& of_first,
                                            const FreeFeatures& of_second, int max_distance) {
  const auto& [first, second, second_from_first, world_from_first] = pair;
  const Eigen::Matrix3d essential = hat(second_from_first.translation()) * second_from_first.rotation().matrix();
  std::vector<EpipolarMatch> best_of(second.frame->size());
  std::vector<std::uint32_t> near;
  for (std::size_t i = 0; i < of_first.features.size(); ++i) {
    const Eigen::Vector3d ray(static_cast<double>(of_first.x[i]), static_cast<double>(of_first.y[i]), 1.0);
    near_line(of_second, essential * ray, near);
    const std::uint32_t feature = of_first.features[i];
    const int level = first.frame->level(feature);
    EpipolarMatch best;
    best.first = feature;
    for (const std::uint32_t k : near) {
      const std::uint32_t other = of_second.features[k];
      if (std::abs(static_cast<int>(second.frame->level(other)) - level) > 2) continue;
      const int distance = hamming_distance(first.frame->descriptor(feature), second.frame->descriptor(other));
      if (distance >= best.distance) continue;
      best.distance = distance;
      best.second = other;
    }
    if (best.distance <= max_distance && best.distance < best_of[best.second].distance) best_of[best.second] = best;
  }
  std::erase_if(best_of, [](const EpipolarMatch& match) { return match.distance > 256; });
  return best_of;
}

/// Squared reprojection error in sigmas.
double squared_error(const MapGraph& graph, const MapKeyframe& keyframe, std::uint32_t feature,
                     const Eigen::Vector3d& point, double pixel_sigma) {
  const Eigen::Vector3d in_camera = keyframe.camera_from_world * point;
  if (!(in_camera.z() > 0.0)) return 1e9;
  const double sigma = pixel_sigma * graph.sigma(*keyframe.frame, feature);
  return (in_camera.head<2>() / in_camera.z() - keyframe.frame->ray(feature)).squaredNorm() / (sigma * sigma);
}

constexpr double chi2_95 = 5.991;  ///< Of two degrees of freedom.

/// In the world; nullopt unless both features fit one point.
std::optional<Eigen::Vector3d> triangulated(const MapGraph& graph, const KeyframePair& pair, const EpipolarMatch& match,
                                            const OrbSlamOptions& options) {
  const auto& [first, second, second_from_first, world_from_first] = pair;
  TriangulationOptions limits;
  limits.focal_px = graph.camera().fx;
  limits.max_error_px = 1e9;
  limits.min_parallax_deg = options.triangulate_parallax_deg;
  const auto point =
      triangulate(second_from_first, first.frame->ray(match.first), second.frame->ray(match.second), limits);
  if (!point) return std::nullopt;
  const Eigen::Vector3d position = world_from_first * point->position;
  if (squared_error(graph, first, match.first, position, options.pixel_sigma) > chi2_95 ||
      squared_error(graph, second, match.second, position, options.pixel_sigma) > chi2_95)
    return std::nullopt;
  // The pyramid levels must be consistent with the distances.
  const double max_ratio = 1.5 * options.scale_factor;
  const double distances = point->position.norm() / (second_from_first * point->position).norm();
  const double scales =
      graph.level_scales()[first.frame->level(match.first)] / graph.level_scales()[second.frame->level(match.second)];
  if (distances * scales > max_ratio || distances * scales < 1.0 / max_ratio) return std::nullopt;
  return position;
}

}  // namespace

void LocalMapping::triangulate_landmarks(std::int64_t keyframe) {
  const auto count = static_cast<std::size_t>(options_.triangulate_neighbors);
  for (const Neighbor& n : graph_.covisible(keyframe, 1, count)) triangulate_with(keyframe, n.id);
}

void LocalMapping::triangulate_with(std::int64_t keyframe, std::int64_t neighbor) {
  const KeyframePair pair(graph_.keyframe(keyframe), graph_.keyframe(neighbor));
  // Minimum baseline relative to the scene depth for one camera; otherwise the camera's own baseline is the minimum.
  constexpr double min_baseline_per_depth = 0.01;
  const double baseline = pair.second_from_first.translation().norm();
  const bool mono = graph_.sensor() == CameraKind::mono;
  if (mono ? baseline < min_baseline_per_depth * median_depth(pair.second) : baseline < graph_.baseline()) return;
  const FreeFeatures of_first = free_features(graph_, pair.first, options_.epipolar_chi2, options_.pixel_sigma);
  const FreeFeatures of_second = free_features(graph_, pair.second, options_.epipolar_chi2, options_.pixel_sigma);
  for (const EpipolarMatch& match : epipolar_matches(pair, of_first, of_second, options_.triangulate_hamming)) {
    const auto position = triangulated(graph_, pair, match, options_);
    if (!position) continue;
    const std::int64_t id = graph_.add_landmark(*position, keyframe).id;
    graph_.add_observation(keyframe, match.first, id);
    graph_.add_observation(neighbor, match.second, id);
    graph_.describe(id);
    recent_.push_back(id);
  }
}

void LocalMapping::fuse_landmarks(std::int64_t keyframe) {
  const std::vector<std::int64_t> targets = fusion_targets(keyframe);
  const std::vector<std::int64_t> own = landmarks_of(graph_.keyframe(keyframe));
  for (const std::int64_t target : targets) fuse_into(target, own);
  std::vector<std::int64_t> theirs;
  for (const std::int64_t target : targets) {
    const std::vector<std::int64_t> landmarks = landmarks_of(graph_.keyframe(target));
    theirs.insert(theirs.end(), landmarks.begin(), landmarks.end());
  }
  std::sort(theirs.begin(), theirs.end());
  theirs.erase(std::unique(theirs.begin(), theirs.end()), theirs.end());
  fuse_into(keyframe, theirs);
}

/// Neighbors and their neighbors; ascending.
std::vector<std::int64_t> LocalMapping::fusion_targets(std::int64_t keyframe) const {
  constexpr std::size_t second_neighbors = 5;
  std::vector<std::int64_t> targets;
  const auto count = static_cast<std::size_t>(options_.triangulate_neighbors);
  for (const Neighbor& n : graph_.covisible(keyframe, 1, count)) {
    targets.push_back(n.id);
    for (const Neighbor& second : graph_.covisible(n.id, options_.covisible_landmarks, second_neighbors)) {
      if (second.id != keyframe) targets.push_back(second.id);
    }
  }
  std::sort(targets.begin(), targets.end());
  targets.erase(std::unique(targets.begin(), targets.end()), targets.end());
  return targets;
}

void LocalMapping::fuse_into(std::int64_t keyframe, const std::vector<std::int64_t>& landmarks) {
  const MapKeyframe& observer = graph_.keyframe(keyframe);
  std::vector<std::int64_t> unseen;
  for (const std::int64_t id : landmarks) {
    if (graph_.has_landmark(id) && graph_.feature_of(keyframe, id) < 0) unseen.push_back(id);
  }
  const auto matches = search_landmarks(graph_, unseen, *observer.frame, Sim3(observer.camera_from_world),
                                        {.radius_px = options_.fuse_px,
                                         .limits = {.max_distance = options_.triangulate_hamming, .max_ratio = 1.0},
                                         .min_view_cosine = std::cos(options_.max_view_angle_deg * M_PI / 180.0),
                                         .check_right_camera = true});
  for (const FeatureMatch& match : matches) {
    const std::int64_t id = unseen[match.subject];
    if (!graph_.has_landmark(id)) continue;
    if (squared_error(graph_, observer, match.feature, graph_.landmark(id).position, options_.pixel_sigma) > chi2_95)
      continue;
    const std::int64_t there = observer.landmarks[match.feature];
    if (there < 0) {
      graph_.add_observation(keyframe, match.feature, id);
      graph_.describe(id);
      continue;
    }
    // Keeps the one with more observations, then the older.
    const std::size_t of_there = graph_.landmark(there).observations.size();
    const std::size_t of_id = graph_.landmark(id).observations.size();
    const bool keep_there = of_there != of_id ? of_there > of_id : there < id;
    graph_.fuse(keep_there ? there : id, keep_there ? id : there);
  }
}

}  // namespace rastro
