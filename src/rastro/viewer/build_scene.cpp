// SPDX-License-Identifier: Apache-2.0
#include "rastro/viewer/build_scene.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "rastro/base/error.h"
#include "rastro/map/cloud/upright.h"
#include "rastro/map/graph/sessions.h"
#include "rastro/viewer/scene_parts.h"

namespace rastro {
namespace {

using detail::KeyframeRows;
using detail::SceneJob;

std::string name_of_recording(const std::string& path) {
  const std::filesystem::path whole(path);
  // A folder may be given with a slash at its end.
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

void add_sessions(const Map& map, ViewScene& scene) {
  for (const MapSession& each : map.sessions)
    scene.sessions.push_back({static_cast<int>(scene.sessions.size()), each.robot, name_of_recording(each.recording),
                              to_seconds(each.first_stamp), to_seconds(each.last_stamp)});
  const MapScale& scale = scale_of(map);
  scene.metric = scale.metric;
  scene.scale_sigma = scale.relative_sigma;
  scene.scale_origin = scale.origin;
}

void add_keyframes(const SceneJob& job, ViewScene& scene) {
  SceneKeyframes& keyframes = scene.keyframes;
  const auto sessions = sessions_of_keyframes(job.map);
  for (const std::size_t index : job.rows.shown()) {
    const Keyframe& keyframe = job.map.keyframes[index];
    keyframes.ids.push_back(static_cast<std::int32_t>(origin_of(keyframe.id).number));
    keyframes.stamps_s.push_back(to_seconds(keyframe.stamp));
    detail::append(keyframes.poses, keyframe.world_from_camera.translation());
    detail::append(keyframes.poses, keyframe.world_from_camera.rotation().quaternion());
    keyframes.sessions.push_back(sessions[index] ? static_cast<int>(*sessions[index]) : -1);
    keyframes.submaps.push_back(keyframe.submap);
  }
}

void add_camera(const Map& map, ViewScene& scene) {
  if (map.cameras.empty() || map.cameras.front().kind == CameraKind::none) return;
  const auto& camera = map.cameras.front().intrinsics;
  if (camera.fx <= 0.0 || camera.width <= 0 || camera.height <= 0) return;
  scene.camera = SceneCamera{camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy};
}

void add_frames(const SceneJob& job, ViewScene& scene) {
  std::set<int> submaps;
  for (const std::size_t index : job.rows.shown()) submaps.insert(job.map.keyframes[index].submap);
  detail::set_frames(trajectory_of(job.map, submaps), scene.frames);
}

/// A planar map lies in x and y; else the normal of the floor, or the mean up direction of the cameras.
std::array<double, 3> up_of(const SceneJob& job, const PointCloud& cloud) {
  if (job.map.cameras.empty()) return {0.0, 0.0, 1.0};
  Trajectory cameras;
  for (const std::size_t index : job.rows.shown()) {
    const Keyframe& keyframe = job.map.keyframes[index];
    cameras.push_back({keyframe.stamp, keyframe.world_from_camera});
  }
  const SO3 upright_from_world = find_upright(cloud, cameras).upright_from_world.rotation();
  const Eigen::Vector3d up = upright_from_world.inverse() * Eigen::Vector3d::UnitZ();
  return {up.x(), up.y(), up.z()};
}

}  // namespace

namespace detail {

KeyframeRows::KeyframeRows(const Map& map, int submap) {
  for (std::size_t index = 0; index < map.keyframes.size(); ++index) {
    const bool is_shown = submap < 0 || map.keyframes[index].submap == submap;
    rows_.push_back(is_shown ? static_cast<std::int64_t>(shown_.size()) : -1);
    if (is_shown) shown_.push_back(index);
  }
}

std::optional<std::uint32_t> KeyframeRows::row(std::size_t index) const {
  if (rows_[index] < 0) return std::nullopt;
  return static_cast<std::uint32_t>(rows_[index]);
}

std::optional<std::uint32_t> KeyframeRows::row_of(const Map& map, KeyframeId id) const {
  const auto index = map.index_of(id);
  return index ? row(*index) : std::nullopt;
}

void set_frames(const Trajectory& trajectory, SceneFrames& frames) {
  frames = {};
  for (const StampedPose& pose : trajectory) {
    frames.stamps_s.push_back(to_seconds(pose.stamp));
    append(frames.positions, pose.world_from_body.translation());
    append(frames.orientations, pose.world_from_body.rotation().quaternion());
  }
}

void append_axes(std::vector<float>& numbers, const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> parts(covariance);
  for (int axis = 0; axis < 3; ++axis)
    append(numbers, std::sqrt(std::max(0.0, parts.eigenvalues()[axis])) * parts.eigenvectors().col(axis));
}

std::vector<std::size_t> evenly(std::size_t count, std::size_t most) {
  std::vector<std::size_t> indices;
  const std::size_t chosen = std::min(count, most);
  for (std::size_t k = 0; k < chosen; ++k) indices.push_back(k * count / chosen);
  return indices;
}

}  // namespace detail

ViewScene build_scene(const Map& map, const ViewSceneOptions& options, TaskPool& pool, const MapProgress& progress) {
  RASTRO_CHECK(options.max_points > 0, "a scene has points");
  const KeyframeRows rows(map, options.submap);
  const SceneJob job{map, options, rows, pool, progress};
  ViewScene scene;
  scene.method = map.method;
  scene.revision = map.revision;
  scene.planar = map.cameras.empty();
  add_sessions(map, scene);
  add_keyframes(job, scene);
  add_camera(map, scene);
  add_frames(job, scene);
  detail::add_graphs(job, scene);
  detail::add_grid(job, scene);
  detail::add_landmarks(job, scene);
  detail::add_layer_points(job, scene);
  scene.up = up_of(job, detail::add_cloud(job, scene));
  detail::add_surfaces(job, scene);
  detail::add_images(job, scene);
  return scene;
}

}  // namespace rastro
