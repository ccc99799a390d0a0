// SPDX-License-Identifier: Apache-2.0
#include "rastro/odometry/features/local_map.h"

#include <algorithm>

#include "rastro/multiview/triangulation.h"

namespace rastro {

void LocalMap::restart() {
  points_.clear();
  // clear() would keep the memory: a recording with many losses would grow.
  for (std::size_t k = window_begin(); k < keyframes_.size(); ++k) keyframes_[k].observations = RayObservations();
  restarted_at_ = keyframes_.size();
}

std::size_t LocalMap::add_keyframe(TimeNs stamp, const SE3& camera_from_world, RayObservations observations) {
  keyframes_.push_back({stamp, camera_from_world, std::move(observations)});
  // Observations outside the window are never used again; points with no other observations go too.
  const std::size_t begin = window_begin();
  if (begin > 0 && begin > restarted_at_) keyframes_[begin - 1].observations = RayObservations();
  std::erase_if(points_, [&](const auto& point) {
    for (std::size_t k = begin; k < keyframes_.size(); ++k) {
      if (find_ray(keyframes_[k].observations, point.first)) return false;
    }
    return true;
  });
  return keyframes_.size() - 1;
}

std::size_t LocalMap::window_begin() const {
  const auto window = static_cast<std::size_t>(options_.window_keyframes);
  return std::max(restarted_at_, keyframes_.size() > window ? keyframes_.size() - window : 0);
}

bool LocalMap::window_is_full() const {
  return keyframes_.size() >= restarted_at_ + static_cast<std::size_t>(options_.window_keyframes);
}

int LocalMap::triangulate() {
  const TriangulationOptions options{focal_px_, options_.max_point_error_px, options_.min_point_parallax_deg};
  int triangulated = 0;
  for (const RayObservation& observation : keyframes_.back().observations) {
    if (points_.contains(observation.id)) continue;
    std::vector<SE3> world_from_camera;
    std::vector<Eigen::Vector2d> rays;
    for (std::size_t k = window_begin(); k < keyframes_.size(); ++k) {
      const Eigen::Vector2d* ray = find_ray(keyframes_[k].observations, observation.id);
      if (!ray) continue;
      world_from_camera.push_back(keyframes_[k].camera_from_world.inverse());
      rays.push_back(*ray);
    }
    if (rays.size() < 2) continue;
    const auto point = rastro::triangulate(world_from_camera, rays, options);
    if (!point) continue;
    points_.emplace(observation.id, point->position);
    ++triangulated;
  }
  return triangulated;
}

RefinementWindow LocalMap::window(std::vector<std::int64_t>& ids) const {
  RefinementWindow window;
  window.focal_px = focal_px_;
  const std::size_t begin = window_begin();
  for (std::size_t k = begin; k < keyframes_.size(); ++k) {
    window.camera_from_world.push_back(keyframes_[k].camera_from_world);
    window.fixed.push_back(k < begin + 2 ? 1 : 0);
  }
  for (const auto& [id, position] : points_) {
    const auto point = static_cast<int>(window.points.size());
    const std::size_t before = window.observations.size();
    for (std::size_t k = begin; k < keyframes_.size(); ++k) {
      const Eigen::Vector2d* ray = find_ray(keyframes_[k].observations, id);
      if (ray) window.observations.push_back({static_cast<int>(k - begin), point, *ray});
    }
    if (window.observations.size() < before + 2) {
      window.observations.resize(before);
      continue;
    }
    window.points.push_back(position);
    ids.push_back(id);
  }
  return window;
}

double LocalMap::refine() {
  std::vector<std::int64_t> ids;
  RefinementWindow window = this->window(ids);
  const std::size_t begin = window_begin();
  const double error = refine_window(window, {options_.refine_iterations, options_.huber_px});
  for (std::size_t k = begin; k < keyframes_.size(); ++k)
    keyframes_[k].camera_from_world = window.camera_from_world[k - begin];
  for (std::size_t i = 0; i < ids.size(); ++i) points_[ids[i]] = window.points[i];
  return error;
}

void LocalMap::drop_bad_points() {
  const std::size_t begin = window_begin();
  std::erase_if(points_, [&](const auto& point) {
    for (std::size_t k = begin; k < keyframes_.size(); ++k) {
      const Eigen::Vector2d* ray = find_ray(keyframes_[k].observations, point.first);
      if (ray && reprojection_error_px(keyframes_[k].camera_from_world, point.second, *ray, focal_px_) >
                     options_.max_point_error_px)
        return true;
    }
    return false;
  });
}

}  // namespace rastro
