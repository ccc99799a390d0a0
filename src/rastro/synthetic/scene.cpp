// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/scene.h"

#include <Eigen/Geometry>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/intersect.h"

namespace rastro {
namespace {

/// Which local axes a box's face picture runs along when it is looked at from outside with up as up.
struct FaceAxes {
  int normal, u, v;
  double sign_u, sign_v;
};
constexpr FaceAxes box_faces[6] = {{0, 1, 2, 1, -1}, {0, 1, 2, -1, -1}, {1, 0, 2, -1, -1},
                                   {1, 0, 2, 1, -1}, {2, 0, 1, 1, -1},  {2, 0, 1, 1, 1}};

int face_count(Shape shape) {
  switch (shape) {
    case Shape::box:
      return 6;
    case Shape::cylinder:
      return 3;
    default:
      return 1;
  }
}

Eigen::Vector2d face_size(const Primitive& primitive, int face) {
  const Eigen::Vector3d& half = primitive.half;
  switch (primitive.shape) {
    case Shape::box:
      return {2.0 * half[box_faces[face].u], 2.0 * half[box_faces[face].v]};
    case Shape::quad:
      return {2.0 * half.x(), 2.0 * half.y()};
    case Shape::cylinder:
      if (face == 0) return {2.0 * std::numbers::pi * half.x(), 2.0 * half.z()};
      return {2.0 * half.x(), 2.0 * half.x()};
    case Shape::sphere:
      return {2.0 * std::numbers::pi * half.x(), std::numbers::pi * half.x()};
  }
  return {0.0, 0.0};
}

FacePoint flat_face(const Primitive& primitive, const FaceAxes& axes, double facing, const Eigen::Vector3d& local) {
  FacePoint result;
  result.u = primitive.half[axes.u] + axes.sign_u * local[axes.u];
  result.v = primitive.half[axes.v] + axes.sign_v * local[axes.v];
  result.normal = facing * primitive.world_from_local.col(axes.normal);
  result.along_u = axes.sign_u * primitive.world_from_local.col(axes.u);
  result.along_v = axes.sign_v * primitive.world_from_local.col(axes.v);
  return result;
}

FacePoint cylinder_side(const Primitive& primitive, const Eigen::Vector3d& local) {
  FacePoint result;
  const double radius = primitive.half.x();
  result.u = radius * (std::atan2(local.y(), local.x()) + std::numbers::pi);
  result.v = primitive.half.z() - local.z();
  const Eigen::Vector3d outward(local.x() / radius, local.y() / radius, 0.0);
  result.normal = primitive.world_from_local * outward;
  result.along_u = primitive.world_from_local * Eigen::Vector3d(-outward.y(), outward.x(), 0.0);
  result.along_v = -primitive.world_from_local.col(2);
  return result;
}

FacePoint sphere_face(const Primitive& primitive, const Eigen::Vector3d& local) {
  FacePoint result;
  const double radius = primitive.half.x();
  const Eigen::Vector3d outward = local / radius;
  const double ring = std::max(1e-3, std::hypot(outward.x(), outward.y()));
  result.u = radius * (std::atan2(outward.y(), outward.x()) + std::numbers::pi);
  result.v = radius * std::acos(std::clamp(outward.z(), -1.0, 1.0));
  result.normal = primitive.world_from_local * outward;
  const Eigen::Vector3d east = Eigen::Vector3d(-outward.y(), outward.x(), 0.0) / ring;
  result.along_u = primitive.world_from_local * east / ring;
  result.along_v = primitive.world_from_local * (-outward.cross(east));
  return result;
}

FacePoint face_point_of(const Primitive& primitive, int face, const Eigen::Vector3d& point) {
  const Eigen::Vector3d local = to_local(primitive, point - primitive.centre);
  switch (primitive.shape) {
    case Shape::box:
      return flat_face(primitive, box_faces[face], (face & 1) != 0 ? -1.0 : 1.0, local);
    case Shape::quad:
      return flat_face(primitive, box_faces[4], 1.0, local);
    case Shape::cylinder:
      break;
    case Shape::sphere:
      return sphere_face(primitive, local);
  }
  if (face == 0) return cylinder_side(primitive, local);
  return flat_face(primitive, box_faces[3 + face], face == 1 ? 1.0 : -1.0, local);
}

}  // namespace

std::uint32_t Scene::add(Primitive primitive, const Material& material) {
  RASTRO_CHECK(material.paint && material.texels_per_metre > 0.0, "a solid needs a painted material");
  primitive.aligned = primitive.world_from_local == Eigen::Matrix3d::Identity();
  primitive.first_surface = static_cast<std::uint32_t>(surfaces_.size());
  const auto number = static_cast<std::uint32_t>(primitives_.size());
  for (int face = 0; face < face_count(primitive.shape); ++face) {
    Surface surface;
    surface.primitive = number;
    surface.face = face;
    const Eigen::Vector2d size = face_size(primitive, face);
    surface.width = size.x(), surface.height = size.y();
    surface.material = material;
    surfaces_.push_back(std::move(surface));
  }
  primitives_.push_back(primitive);
  tree_ = {};
  return number;
}

std::uint32_t Scene::add_box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, const Material& material,
                             double yaw) {
  Primitive box;
  box.centre = centre;
  box.half = 0.5 * size;
  if (yaw != 0.0) box.world_from_local = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return add(box, material);
}

std::uint32_t Scene::add_cylinder(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius,
                                  const Material& material) {
  Primitive cylinder;
  cylinder.shape = Shape::cylinder;
  cylinder.centre = 0.5 * (from + to);
  cylinder.half = {radius, radius, 0.5 * (to - from).norm()};
  const Eigen::Vector3d axis = (to - from).normalized();
  if (axis != Eigen::Vector3d::UnitZ())
    cylinder.world_from_local = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
  return add(cylinder, material);
}

std::uint32_t Scene::add_sphere(const Eigen::Vector3d& centre, double radius, const Material& material) {
  Primitive sphere;
  sphere.shape = Shape::sphere;
  sphere.centre = centre;
  sphere.half.setConstant(radius);
  return add(sphere, material);
}

std::uint32_t Scene::add_quad(const Eigen::Vector3d& centre, const Eigen::Vector3d& right, const Eigen::Vector3d& down,
                              const Material& material) {
  Primitive quad;
  quad.shape = Shape::quad;
  quad.centre = centre;
  quad.half = {0.5 * right.norm(), 0.5 * down.norm(), 0.0};
  quad.world_from_local.col(0) = right.normalized();
  quad.world_from_local.col(1) = -down.normalized();
  quad.world_from_local.col(2) = quad.world_from_local.col(0).cross(quad.world_from_local.col(1));
  return add(quad, material);
}

void Scene::paint_face(std::uint32_t primitive, int face, const Material& material) {
  surfaces_[primitives_[primitive].first_surface + static_cast<std::uint32_t>(face)].material = material;
}

std::optional<RayHit> Scene::trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                   double limit) const {
  Meeting best;
  best.t = limit;
  const Primitive* met = nullptr;
  const auto test = [&](std::uint32_t number) {
    const Primitive& primitive = primitives_[number];
    const Meeting meeting = meet(primitive, to_local(primitive, origin - primitive.centre), direction);
    if (meeting.t < best.t) {
      best = meeting;
      met = &primitive;
    }
    return best.t;
  };
  if (tree_.empty()) {
    for (std::uint32_t number = 0; number < primitives_.size(); ++number) test(number);
  } else {
    tree_.visit(origin, direction, limit, test);
  }
  if (met == nullptr) return std::nullopt;
  return RayHit{best.t, met->first_surface + static_cast<std::uint32_t>(best.face), origin + best.t * direction};
}

FacePoint Scene::face_point(std::uint32_t surface, const Eigen::Vector3d& point) const {
  const Surface& face = surfaces_[surface];
  return face_point_of(primitives_[face.primitive], face.face, point);
}

bool Scene::touches(const Eigen::Vector3d& centre, double radius) const {
  for (const Primitive& primitive : primitives_) {
    const Eigen::Vector3d local = to_local(primitive, centre - primitive.centre);
    const Eigen::Vector3d outside = (local.cwiseAbs() - primitive.half).cwiseMax(0.0);
    if (outside.norm() < radius) return true;
  }
  return false;
}

std::size_t Scene::texture_bytes() const {
  std::size_t total = 0;
  for (const Surface& surface : surfaces_) total += surface.texture.bytes();
  return total;
}

}  // namespace rastro
