// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "rastro/export/mcap/foxglove_messages.h"
#if RASTRO_WITH_MCAP
#include "rastro/export/mcap/foxglove_parts.h"

namespace rastro::detail {
namespace {

using Color4 = std::array<double, 4>;

constexpr double line_px = 1.5;
constexpr Color4 keyframe_color{0.35, 0.55, 1.0, 1.0}, truth_color{0.3, 0.8, 0.3, 1.0},
    ellipsoid_color{1.0, 0.6, 0.1, 0.35};

Color4 color_of_edges(const std::string& name) {
  if (name == "loops" || name == "merges" || name == "inter_robot") return {0.95, 0.25, 0.25, 1.0};
  if (name == "covisibility") return {0.45, 0.65, 0.45, 0.35};
  return {0.55, 0.55, 0.55, 0.9};
}

foxglove::SceneEntity& add_entity(TimeNs time, const std::string& id, foxglove::SceneUpdate& scene) {
  foxglove::SceneEntity& entity = *scene.add_entities();
  set_time(time, *entity.mutable_timestamp());
  entity.set_frame_id(world_frame);
  entity.set_id(id);
  return entity;
}

foxglove::LinePrimitive& add_lines(foxglove::LinePrimitive::Type type, const SE3& pose, const Color4& color,
                                   foxglove::SceneEntity& entity) {
  foxglove::LinePrimitive& lines = *entity.add_lines();
  lines.set_type(type);
  set_pose(pose, *lines.mutable_pose());
  lines.set_thickness(line_px);
  lines.set_scale_invariant(true);
  set_color(color, *lines.mutable_color());
  return lines;
}

/// Depth of the frustums: the median step between keyframes.
double frustum_size(const std::vector<McapRun::Keyframe>& keyframes) {
  constexpr double alone = 0.1;
  std::vector<double> steps;
  for (std::size_t k = 1; k < keyframes.size(); ++k) {
    const Eigen::Vector3d step =
        keyframes[k].pose.world_from_body.translation() - keyframes[k - 1].pose.world_from_body.translation();
    if (step.norm() > 0.0) steps.push_back(step.norm());
  }
  if (steps.empty()) return alone;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

void add_point(double x, double y, double z, foxglove::LinePrimitive& lines) {
  set_vector(Eigen::Vector3d(x, y, z), *lines.add_points());
}

/// Edges of the pyramid in front of the camera; its image plane is `size` ahead.
void add_frustum(const std::optional<Camera>& camera, double size, foxglove::LinePrimitive& lines) {
  constexpr double usual_x = 0.6, usual_y = 0.45;
  const bool known = camera && camera->fx > 0.0 && camera->fy > 0.0;
  const double x = size * (known ? 0.5 * camera->width / camera->fx : usual_x);
  const double y = size * (known ? 0.5 * camera->height / camera->fy : usual_y);
  const std::array<std::array<double, 2>, 4> corners{{{-x, -y}, {x, -y}, {x, y}, {-x, y}}};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const auto &from = corners[k], &to = corners[(k + 1) % corners.size()];
    add_point(0.0, 0.0, 0.0, lines);
    add_point(from[0], from[1], size, lines);
    add_point(from[0], from[1], size, lines);
    add_point(to[0], to[1], size, lines);
  }
}

/// A triangle in x and y whose tip is ahead.
void add_arrow(double size, foxglove::LinePrimitive& lines) {
  const double width = 0.4 * size;
  const std::array<std::array<double, 2>, 3> corners{{{size, 0.0}, {0.0, width}, {0.0, -width}}};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const auto &from = corners[k], &to = corners[(k + 1) % corners.size()];
    add_point(from[0], from[1], 0.0, lines);
    add_point(to[0], to[1], 0.0, lines);
  }
}

void add_ellipsoid(const Eigen::Vector3d& center, const Eigen::Matrix3d& covariance, foxglove::SceneEntity& entity) {
  constexpr double thinnest = 1e-6;       // relative; a flat one has no surface that could be lit
  if (covariance.trace() <= 0.0) return;  // a pose by definition: the first
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> parts(covariance);
  Eigen::Matrix3d axes = parts.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  const Eigen::Vector3d sigmas = parts.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const double least = thinnest * sigmas.maxCoeff();
  foxglove::SpherePrimitive& sphere = *entity.add_spheres();
  set_pose(SE3(SO3(Eigen::Quaterniond(axes)), center), *sphere.mutable_pose());
  set_vector(2.0 * sigmas.cwiseMax(least), *sphere.mutable_size());  // from side to side
  set_color(ellipsoid_color, *sphere.mutable_color());
}

}  // namespace

std::string keyframes_message(TimeNs time, const McapRun& run) {
  const double size = frustum_size(run.keyframes);
  foxglove::SceneUpdate scene;
  for (const McapRun::Keyframe& keyframe : run.keyframes) {
    foxglove::SceneEntity& entity = add_entity(time, "keyframe " + keyframe.name, scene);
    foxglove::KeyValuePair& stamp = *entity.add_metadata();
    stamp.set_key("stamp_ns");
    stamp.set_value(std::to_string(keyframe.pose.stamp));
    auto& lines = add_lines(foxglove::LinePrimitive::LINE_LIST, keyframe.pose.world_from_body, keyframe_color, entity);
    if (run.of_camera)
      add_frustum(run.camera, size, lines);
    else
      add_arrow(size, lines);
  }
  return bytes_of_message(scene);
}

std::string graph_message(TimeNs time, const McapRun& run) {
  foxglove::SceneUpdate scene;
  for (const McapRun::Edges& edges : run.edges) {
    auto& lines = add_lines(foxglove::LinePrimitive::LINE_LIST, SE3(), color_of_edges(edges.name),
                            add_entity(time, edges.name, scene));
    for (const auto& pair : edges.pairs)
      for (const std::uint32_t row : pair)
        set_vector(run.keyframes.at(row).pose.world_from_body.translation(), *lines.add_points());
  }
  return bytes_of_message(scene);
}

std::string covariances_message(TimeNs time, const McapRun& run) {
  foxglove::SceneUpdate scene;
  for (const McapRun::Ellipsoids& ellipsoids : run.ellipsoids) {
    foxglove::SceneEntity& entity = add_entity(time, ellipsoids.name, scene);
    for (std::size_t k = 0; k < ellipsoids.centers.size(); ++k)
      add_ellipsoid(ellipsoids.centers[k], ellipsoids.covariances.at(k), entity);
  }
  return bytes_of_message(scene);
}

std::string path_message(TimeNs time, const std::string& name, const std::vector<Eigen::Vector3d>& path) {
  foxglove::SceneUpdate scene;
  auto& lines = add_lines(foxglove::LinePrimitive::LINE_STRIP, SE3(), truth_color, add_entity(time, name, scene));
  for (const Eigen::Vector3d& position : path) set_vector(position, *lines.add_points());
  return bytes_of_message(scene);
}

}  // namespace rastro::detail
#endif
