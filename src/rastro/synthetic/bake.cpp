// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <array>
#include <numbers>

#include "rastro/synthetic/scene.h"

namespace rastro {
namespace {

constexpr double reach_m = 3.0;           // Nothing farther than this occludes light.
constexpr double texels_per_node = 16.0;  // Coarsely painted surfaces are lit coarsely.

/// World point and outward normal of a point on a face, found from the center of the face's local frame.
struct PointOnFace {
  Eigen::Vector3d point, normal;
};

PointOnFace point_on(const Scene& scene, const Surface& surface, double u, double v) {
  const Primitive& solid = scene.primitives()[surface.primitive];
  const Eigen::Vector3d& half = solid.half;
  Eigen::Vector3d local = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  if (solid.shape == Shape::sphere || (solid.shape == Shape::cylinder && surface.face == 0)) {
    const double longitude = u / half.x() - std::numbers::pi;
    const double colatitude = solid.shape == Shape::sphere ? v / half.x() : 0.5 * std::numbers::pi;
    normal = {std::cos(longitude) * std::sin(colatitude), std::sin(longitude) * std::sin(colatitude),
              std::cos(colatitude)};
    local = half.x() * normal;
    if (solid.shape == Shape::cylinder) local.z() = half.z() - v, normal.z() = 0.0;
    return {solid.center + solid.world_from_local * local, solid.world_from_local * normal};
  }
  // Flat faces: the texture's axes are constant, so start at the face's center.
  const int axis = solid.shape == Shape::box ? surface.face / 2 : 2;
  const bool negative = solid.shape == Shape::box ? (surface.face & 1) != 0 : surface.face == 2;
  local[axis] = negative ? -half[axis] : half[axis];
  const Eigen::Vector3d middle = solid.center + solid.world_from_local * local;
  const FacePoint face = scene.face_point(solid.first_surface + static_cast<std::uint32_t>(surface.face), middle);
  return {middle + (u - face.u) * face.along_u + (v - face.v) * face.along_v, face.normal};
}

/// Evenly spread directions (Fibonacci sphere), the same for every point: noise between neighboring nodes would show
/// as blotches.
std::array<Eigen::Vector3d, 40> directions() {
  std::array<Eigen::Vector3d, 40> result;
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(result.size());
    const double angle = static_cast<double>(i) * std::numbers::pi * (3.0 - std::sqrt(5.0));
    result[i] = {std::sqrt(1.0 - z * z) * std::cos(angle), std::sqrt(1.0 - z * z) * std::sin(angle), z};
  }
  return result;
}

/// Light that reaches a point: lamps above, windows to the sides, less in corners. About 1 in the open.
double light_at(const Scene& scene, std::uint32_t primitive, const PointOnFace& at) {
  static const std::array<Eigen::Vector3d, 40> rays = directions();
  double light = 0.0, weight = 0.0;
  const Eigen::Vector3d origin = at.point + 2e-3 * at.normal;
  for (const Eigen::Vector3d& ray : rays) {
    const double slope = ray.dot(at.normal);
    if (slope <= 0.05) continue;
    const std::optional<RayHit> hit = scene.trace_beside(primitive, origin, ray, reach_m);
    const double open = hit ? 0.25 + 0.75 * hit->t / reach_m : 1.0;
    light += slope * open * (1.18 + 0.60 * ray.z() + 0.3 * ray.y() - 0.2 * ray.x());
    weight += slope;
  }
  return weight > 0.0 ? light / weight : 1.0;
}

Image<float> light_map(const Scene& scene, const Surface& surface, double detail, double finest_spacing_m) {
  // In small images light is less visible than surfaces, but takes most of the time.
  const double node_spacing_m =
      std::max(finest_spacing_m, texels_per_node / surface.material.texels_per_meter) / std::clamp(detail, 0.25, 1.0);
  const int columns = 2 + static_cast<int>(surface.width / node_spacing_m),
            rows = 2 + static_cast<int>(surface.height / node_spacing_m);
  Image<float> map(columns, rows);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      // A little inside the border, where a neighboring solid does not yet cover the point.
      const double u = std::clamp(surface.width * column / (columns - 1), 0.01, std::max(0.01, surface.width - 0.01));
      const double v = std::clamp(surface.height * row / (rows - 1), 0.01, std::max(0.01, surface.height - 0.01));
      map.at(column, row) = static_cast<float>(light_at(scene, surface.primitive, point_on(scene, surface, u, v)));
    }
  return map;
}

void multiply(Image<float>& values, const Image<float>& map) {
  const float scale_x = static_cast<float>(map.width() - 1) / static_cast<float>(values.width());
  const float scale_y = static_cast<float>(map.height() - 1) / static_cast<float>(values.height());
  for (int y = 0; y < values.height(); ++y) {
    const float map_y = (static_cast<float>(y) + 0.5F) * scale_y;
    const int top = std::min(static_cast<int>(map_y), map.height() - 2);
    const float v = map_y - static_cast<float>(top);
    for (int x = 0; x < values.width(); ++x) {
      const float map_x = (static_cast<float>(x) + 0.5F) * scale_x;
      const int left = std::min(static_cast<int>(map_x), map.width() - 2);
      const float u = map_x - static_cast<float>(left);
      const float above = map.at(left, top) + u * (map.at(left + 1, top) - map.at(left, top));
      const float below = map.at(left, top + 1) + u * (map.at(left + 1, top + 1) - map.at(left, top + 1));
      values.at(x, y) *= above + v * (below - above);
    }
  }
}

}  // namespace

namespace {

/// Seed of the painter of a face.
std::uint64_t painter_seed(std::uint64_t seed, const Surface& surface, int index) {
  if (surface.material.likeness == 0) return seed_for(seed, static_cast<std::uint64_t>(index));
  return seed_for(seed_for(seed, ~surface.material.likeness), static_cast<std::uint64_t>(surface.face));
}

}  // namespace

void Scene::make_tree() { tree_ = std::make_shared<const BoundsTree>(std::span(primitives_).first(still_count())); }

void Scene::bake(std::uint64_t seed, TaskPool& pool, double detail, double light_spacing_m) {
  make_tree();
  pool.for_chunks(0, static_cast<int>(surfaces_->size()), 1, [&](int begin, int end) {
    for (int index = begin; index < end; ++index) {
      Surface& surface = (*surfaces_)[static_cast<std::size_t>(index)];
      Random random(painter_seed(seed, surface, index));
      Canvas canvas(surface.width, surface.height, detail * surface.material.texels_per_meter);
      surface.material.paint(canvas, random);
      if (!surface.material.shines) multiply(canvas.values(), light_map(*this, surface, detail, light_spacing_m));
      surface.texture = Texture(canvas.values());
      if (!canvas.inks().empty()) surface.colors = ColorTexture(canvas.values(), canvas.ink_of(), canvas.inks());
      surface.texels_x = canvas.values().width() / surface.width;
      surface.texels_y = canvas.values().height() / surface.height;
    }
  });
}

}  // namespace rastro
