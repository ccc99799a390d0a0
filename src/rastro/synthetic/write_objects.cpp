// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/write_objects.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

#include "rastro/synthetic/recording_files.h"

namespace rastro {
namespace {

static_assert(std::endian::native == std::endian::little, "the mesh is written as in memory");

using Eigen::Vector3d;

constexpr double click_m = 0.02;

std::string roughly(const Vector3d& point) {
  const Vector3d steps = (point / click_m).array().round();
  // The sum converts -0 to 0.
  return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", steps.x() * click_m + 0.0, steps.y() * click_m + 0.0,
                     steps.z() * click_m + 0.0);
}

std::string edge_text(const char* key, const NamedEdge& edge, const Vector3d& face, const SE3& camera_from_world) {
  const Vector3d along = camera_from_world.rotation() * edge.direction;
  return fmt::format("    {}: {{point: {}, direction: [{:.2f}, {:.2f}, {:.2f}], face: {}}}\n", key,
                     roughly(camera_from_world * edge.middle), along.x() + 0.0, along.y() + 0.0, along.z() + 0.0,
                     roughly(camera_from_world * face));
}

struct Vertex {
  float x, y, z;
};
struct Rgb {
  std::uint8_t red, green, blue;
};

std::uint8_t mean_of(const Texture& texture) {
  int last = 0;
  while (texture.level(last).width() > 1 || texture.level(last).height() > 1) ++last;
  return texture.level(last).at(0, 0);
}

Rgb mean_color(const Surface& surface) {
  const std::uint8_t gray = mean_of(surface.texture);
  if (surface.colors.empty()) return {gray, gray, gray};
  const Eigen::Array4f mean = surface.colors.mean();
  return {static_cast<std::uint8_t>(mean[0]), static_cast<std::uint8_t>(mean[1]), static_cast<std::uint8_t>(mean[2])};
}

class Mesh {
 public:
  explicit Mesh(const SE3& mesh_from_world) : mesh_from_world_(mesh_from_world) {}

  void add_face(const Primitive& solid, int face, const Rgb& color) {
    const bool round = solid.shape == Shape::cylinder || solid.shape == Shape::sphere;
    const int columns = round ? 48 : 1, rows = solid.shape == Shape::sphere ? 24 : 1;
    // Explicit type: an Eigen expression would outlive the objects it refers to.
    const auto position = [&](int column, int row) -> Vector3d {
      return solid.center + solid.world_from_local * local_position(solid, face, static_cast<double>(column) / columns,
                                                                    static_cast<double>(row) / rows);
    };
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) {
        const Vector3d a = position(column, row), b = position(column + 1, row), c = position(column + 1, row + 1),
                       d = position(column, row + 1);
        add_triangle(a, b, c, solid, color);
        add_triangle(a, c, d, solid, color);
      }
  }
  void add_glass(const GlassSheet& sheet) {
    Primitive quad;
    quad.shape = Shape::quad;
    quad.center = sheet.center;
    quad.half = {0.5 * sheet.right.norm(), 0.5 * sheet.down.norm(), 0.0};
    quad.world_from_local.col(0) = sheet.right.normalized();
    quad.world_from_local.col(1) = -sheet.down.normalized();
    quad.world_from_local.col(2) = quad.world_from_local.col(0).cross(quad.world_from_local.col(1));
    add_face(quad, 0, {190, 215, 205});
  }

  std::string ply(const std::string& name) const {
    const std::size_t faces = vertices_.size() / 3;
    std::string text = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment {}: surfaces in the frame of the first camera, meters\n"
        "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        name, vertices_.size(), faces);
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      text.append(reinterpret_cast<const char*>(&vertices_[i]), sizeof(Vertex));
      text.append(reinterpret_cast<const char*>(&colors_[i]), sizeof(Rgb));
    }
    for (std::size_t face = 0; face < faces; ++face) {
      text += '\3';
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const auto index = static_cast<std::int32_t>(3 * face + corner);
        text.append(reinterpret_cast<const char*>(&index), sizeof(index));
      }
    }
    return text;
  }

 private:
  /// A face as a square of s and t in 0..1.
  static Vector3d local_position(const Primitive& solid, int face, double s, double t) {
    const Vector3d& half = solid.half;
    const double longitude = 2.0 * std::numbers::pi * s;
    switch (solid.shape) {
      case Shape::box: {
        Vector3d position;
        const int axis = face / 2;
        position[axis] = (face & 1) != 0 ? -half[axis] : half[axis];
        position[(axis + 1) % 3] = (2.0 * s - 1.0) * half[(axis + 1) % 3];
        position[(axis + 2) % 3] = (2.0 * t - 1.0) * half[(axis + 2) % 3];
        return position;
      }
      case Shape::quad:
        return {(2.0 * s - 1.0) * half.x(), (2.0 * t - 1.0) * half.y(), 0.0};
      case Shape::cylinder: {
        const double radius = face == 0 ? half.x() : t * half.x();
        const double z = face == 0 ? (2.0 * t - 1.0) * half.z() : face == 1 ? half.z() : -half.z();
        return {radius * std::cos(longitude), radius * std::sin(longitude), z};
      }
      case Shape::sphere: {
        const double colatitude = std::numbers::pi * t;
        return half.x() * Vector3d(std::sin(colatitude) * std::cos(longitude),
                                   std::sin(colatitude) * std::sin(longitude), std::cos(colatitude));
      }
    }
    return Vector3d::Zero();
  }

  /// Counter-clockwise from outside; those without an area (at poles and at the centers of caps) are left out.
  void add_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Primitive& solid, const Rgb& color) {
    const Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() < 1e-12) return;
    const bool inward = normal.dot((a + b + c) / 3.0 - solid.center) < 0.0;
    for (const Vector3d& corner : {a, inward ? c : b, inward ? b : c}) {
      const Vector3d vertex = mesh_from_world_ * corner;
      vertices_.push_back(
          {static_cast<float>(vertex.x()), static_cast<float>(vertex.y()), static_cast<float>(vertex.z())});
      colors_.push_back(color);
    }
  }

  SE3 mesh_from_world_;
  std::vector<Vertex> vertices_;
  std::vector<Rgb> colors_;
};

}  // namespace

std::string objects_text(const World& world, std::int64_t first) {
  std::string text =
      "# Lengths to measure in a map of this recording. Meters. Points are rough, in the frame of the first camera\n"
      "# (x right, y down, z forward); length_m is exact.\n"
      "frame: first_camera\nobjects:\n";
  const SE3 camera_from_world = world.world_from_camera(first).inverse();
  for (const NamedLength& length : world.lengths()) {
    text += fmt::format("  - name: {}\n    length_m: {:.10g}\n    kind: edges\n", length.name, length.length_m);
    text += edge_text("a", length.a, length.face, camera_from_world);
    text += edge_text("b", length.b, length.face, camera_from_world);
  }
  return text;
}

std::uintmax_t write_ground_truth_mesh(const World& world, const std::filesystem::path& file, std::int64_t first) {
  Mesh mesh(world.world_from_camera(first).inverse());
  const Scene scene = world.scene_at(first);
  for (const Surface& surface : scene.surfaces())
    mesh.add_face(scene.primitives()[surface.primitive], surface.face, mean_color(surface));
  for (const GlassSheet& sheet : scene.glass()) mesh.add_glass(sheet);
  const std::string ply = mesh.ply(world.name());
  TextFile(file, ply);
  return ply.size();
}

}  // namespace rastro
