// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "rastro/feature/hamming.h"
#include "rastro/math/so3.h"
#include "rastro/multiview/triangulation.h"
#include "rastro/slam/orb/local_mapper.h"
#include "rastro/slam/orb/matching.h"
#include "rastro/slam/orb/near_line.h"

namespace rastro {
namespace {

/// Features of a keyframe that show no landmark yet, side by side.
struct FreeFeatures {
  std::vector<float> x, y, limit;  ///< Normalised; squared distance from an epipolar line.
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

/// Indices into `free` of what lies near the line a x + b y + c = 0.
void near_line(const FreeFeatures& free, const Eigen::Vector3d& line, std::vector<std::uint32_t>& found) {
  found.clear();
  const double norm = line.head<2>().norm();
  if (!(norm > 0.0)) return;
  const Eigen::Vector3f unit = (line / norm).cast<float>();
  find_near_line(free.x, free.y, free.limit, unit.x(), unit.y(), unit.z(), found);
}

struct EpipolarMatch {
  std::uint32_t first = 0, second = 0;
  int distance = 257;
};

std::vector<EpipolarMatch> epipolar_matches(const MapKeyframe& first, const MapKeyframe& second,
                                            const FreeFeatures& of_first, const FreeFeatures& of_second,
                                            int max_distance) {
  const SE3 second_from_first = second.camera_from_world * first.camera_from_world.inverse();
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

}  // namespace

void LocalMapper::triangulate(std::int64_t keyframe) {
  const auto count = static_cast<std::size_t>(options_.triangulate_neighbours);
  for (const Neighbour& n : graph_.covisible(keyframe, 1, count)) triangulate_with(keyframe, n.id);
}

int LocalMapper::triangulate_with(std::int64_t keyframe, std::int64_t neighbour) {
  const MapKeyframe& first = graph_.keyframe(keyframe);
  const MapKeyframe& second = graph_.keyframe(neighbour);
  const SE3 second_from_first = second.camera_from_world * first.camera_from_world.inverse();
  const double baseline = second_from_first.translation().norm();
  const bool mono = graph_.sensor() == CameraKind::mono;
  if (mono ? baseline < 0.01 * median_depth(second) : baseline < graph_.baseline()) return 0;
  const FreeFeatures of_first = free_features(graph_, first, options_.epipolar_chi2, options_.pixel_sigma);
  const FreeFeatures of_second = free_features(graph_, second, options_.epipolar_chi2, options_.pixel_sigma);
  TriangulationOptions limits;
  limits.focal_px = graph_.camera().fx;
  limits.max_error_px = 1e9;
  limits.min_parallax_deg = options_.triangulate_parallax_deg;
  const SE3 world_from_first = first.camera_from_world.inverse();
  const double largest_ratio = 1.5 * options_.scale_factor;
  int made = 0;
  for (const EpipolarMatch& match :
       epipolar_matches(first, second, of_first, of_second, options_.triangulate_hamming)) {
    const auto point =
        rastro::triangulate(second_from_first, first.frame->ray(match.first), second.frame->ray(match.second), limits);
    if (!point) continue;
    const Eigen::Vector3d position = world_from_first * point->position;
    if (squared_error(graph_, first, match.first, position, options_.pixel_sigma) > 5.991 ||
        squared_error(graph_, second, match.second, position, options_.pixel_sigma) > 5.991)
      continue;
    // What is nearer looks larger.
    const double distances = point->position.norm() / (second_from_first * point->position).norm();
    const double scales = graph_.level_scales()[first.frame->level(match.first)] /
                          graph_.level_scales()[second.frame->level(match.second)];
    if (distances * scales > largest_ratio || distances * scales < 1.0 / largest_ratio) continue;
    const std::int64_t id = graph_.add_landmark(position, keyframe).id;
    graph_.add_observation(keyframe, match.first, id);
    graph_.add_observation(neighbour, match.second, id);
    graph_.describe(id);
    recent_.push_back(id);
    ++made;
  }
  return made;
}

void LocalMapper::fuse(std::int64_t keyframe) {
  std::vector<std::int64_t> targets;
  const auto count = static_cast<std::size_t>(options_.triangulate_neighbours);
  for (const Neighbour& n : graph_.covisible(keyframe, 1, count)) {
    targets.push_back(n.id);
    for (const Neighbour& second : graph_.covisible(n.id, options_.covisible_landmarks, 5)) {
      if (second.id != keyframe) targets.push_back(second.id);
    }
  }
  std::sort(targets.begin(), targets.end());
  targets.erase(std::unique(targets.begin(), targets.end()), targets.end());
  std::vector<std::int64_t> own;
  for (const std::int64_t id : graph_.keyframe(keyframe).landmarks) {
    if (id >= 0) own.push_back(id);
  }
  for (const std::int64_t target : targets) fuse_into(target, own);
  std::vector<std::int64_t> theirs;
  for (const std::int64_t target : targets) {
    for (const std::int64_t id : graph_.keyframe(target).landmarks) {
      if (id >= 0) theirs.push_back(id);
    }
  }
  std::sort(theirs.begin(), theirs.end());
  theirs.erase(std::unique(theirs.begin(), theirs.end()), theirs.end());
  fuse_into(keyframe, theirs);
}

void LocalMapper::fuse_into(std::int64_t keyframe, const std::vector<std::int64_t>& landmarks) {
  const MapKeyframe& seer = graph_.keyframe(keyframe);
  const Camera& camera = graph_.camera();
  const Eigen::Vector3d centre = seer.camera_from_world.inverse().translation();
  const double least_cosine = std::cos(options_.max_view_angle_deg * M_PI / 180.0);
  std::vector<ExpectedFeature> expected;
  std::vector<std::int64_t> subjects;
  for (const std::int64_t id : landmarks) {
    if (!graph_.has_landmark(id) || graph_.feature_of(keyframe, id) >= 0) continue;
    const MapLandmark& landmark = graph_.landmark(id);
    const Eigen::Vector3d p = seer.camera_from_world * landmark.position;
    const Eigen::Vector3d way = landmark.position - centre;
    const double distance = way.norm();
    if (!(p.z() > 0.0) || distance < 0.8 * static_cast<double>(landmark.min_distance) ||
        distance > 1.25 * static_cast<double>(landmark.max_distance) ||
        way.dot(landmark.direction) < least_cosine * distance)
      continue;
    const auto x = static_cast<float>(camera.fx * p.x() / p.z() + camera.cx);
    const auto y = static_cast<float>(camera.fy * p.y() / p.z() + camera.cy);
    if (!seer.frame->holds(x, y)) continue;
    const int last = options_.levels - 1;
    const int level = std::clamp(
        static_cast<int>(std::ceil(
            std::log(static_cast<double>(landmark.max_distance) / distance) / std::log(options_.scale_factor) - 0.5)),
        0, last);
    const float right = graph_.baseline() > 0.0
                            ? static_cast<float>(static_cast<double>(x) - camera.fx * graph_.baseline() / p.z())
                            : std::nanf("");
    expected.push_back({static_cast<std::uint32_t>(subjects.size()), x, y,
                        static_cast<float>(options_.fuse_px * graph_.level_scales()[static_cast<std::size_t>(level)]),
                        right, static_cast<std::uint8_t>(std::max(0, level - 1)),
                        static_cast<std::uint8_t>(std::min(last, level + 1)), &landmark.descriptor});
    subjects.push_back(id);
  }
  const auto matches =
      match_expected(*seer.frame, expected, {.max_distance = options_.triangulate_hamming, .max_ratio = 1.0});
  for (const FeatureMatch& match : matches) {
    const std::int64_t id = subjects[match.subject];
    if (!graph_.has_landmark(id)) continue;
    if (squared_error(graph_, seer, match.feature, graph_.landmark(id).position, options_.pixel_sigma) > 5.991)
      continue;
    const std::int64_t there = seer.landmarks[match.feature];
    if (there < 0) {
      graph_.add_observation(keyframe, match.feature, id);
      graph_.describe(id);
      continue;
    }
    const std::size_t of_there = graph_.landmark(there).observations.size();
    const std::size_t of_id = graph_.landmark(id).observations.size();
    const bool keep_there = of_there != of_id ? of_there > of_id : there < id;
    graph_.fuse(keep_there ? there : id, keep_there ? id : there);
  }
}

}  // namespace rastro
