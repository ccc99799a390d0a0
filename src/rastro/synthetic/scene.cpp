// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/scene.h"

#include <Eigen/Geometry>
#include <numbers>

#include "rastro/base/error.h"
#include "rastro/synthetic/intersect.h"

namespace rastro {
namespace {

/// Local axes of the texture on each face of a box, seen from outside with up as up.
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
  const Eigen::Vector3d local = to_local(primitive, point - primitive.center);
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
  RASTRO_CHECK(material.paint && material.texels_per_meter > 0.0, "a solid needs a painted material");
  primitive.aligned = primitive.world_from_local == Eigen::Matrix3d::Identity();
  primitive.first_surface = static_cast<std::uint32_t>(surfaces_->size());
  const auto number = static_cast<std::uint32_t>(primitives_.size());
  for (int face = 0; face < face_count(primitive.shape); ++face) {
    Surface surface;
    surface.primitive = number;
    surface.face = face;
    const Eigen::Vector2d size = face_size(primitive, face);
    surface.width = size.x(), surface.height = size.y();
    surface.material = material;
    surfaces_->push_back(std::move(surface));
  }
  primitives_.push_back(primitive);
  tree_ = std::make_shared<const BoundsTree>();
  return number;
}

std::uint32_t Scene::add_box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, const Material& material,
                             double yaw) {
  Primitive box;
  box.center = center;
  box.half = 0.5 * size;
  if (yaw != 0.0) box.world_from_local = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return add(box, material);
}

std::uint32_t Scene::add_cylinder(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius,
                                  const Material& material) {
  Primitive cylinder;
  cylinder.shape = Shape::cylinder;
  cylinder.center = 0.5 * (from + to);
  cylinder.half = {radius, radius, 0.5 * (to - from).norm()};
  const Eigen::Vector3d axis = (to - from).normalized();
  if (axis != Eigen::Vector3d::UnitZ())
    cylinder.world_from_local = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
  return add(cylinder, material);
}

std::uint32_t Scene::add_sphere(const Eigen::Vector3d& center, double radius, const Material& material) {
  Primitive sphere;
  sphere.shape = Shape::sphere;
  sphere.center = center;
  sphere.half.setConstant(radius);
  return add(sphere, material);
}

std::uint32_t Scene::add_quad(const Eigen::Vector3d& center, const Eigen::Vector3d& right, const Eigen::Vector3d& down,
                              const Material& material) {
  Primitive quad;
  quad.shape = Shape::quad;
  quad.center = center;
  quad.half = {0.5 * right.norm(), 0.5 * down.norm(), 0.0};
  quad.world_from_local.col(0) = right.normalized();
  quad.world_from_local.col(1) = -down.normalized();
  quad.world_from_local.col(2) = quad.world_from_local.col(0).cross(quad.world_from_local.col(1));
  return add(quad, material);
}

void Scene::paint_face(std::uint32_t primitive, int face, const Material& material) {
  (*surfaces_)[primitives_[primitive].first_surface + static_cast<std::uint32_t>(face)].material = material;
}

void Scene::begin_moving(Motion motion) {
  RASTRO_CHECK(motion, "a moving object needs a motion");
  movers_.push_back({static_cast<std::uint32_t>(primitives_.size()), std::move(motion)});
}

std::uint32_t Scene::still_count() const {
  return movers_.empty() ? static_cast<std::uint32_t>(primitives_.size()) : movers_.front().first;
}

std::uint32_t Scene::end_of(std::size_t mover) const {
  return mover + 1 < movers_.size() ? movers_[mover + 1].first : static_cast<std::uint32_t>(primitives_.size());
}

Scene Scene::at(double time_s) const {
  Scene result = *this;
  for (std::size_t mover = 0; mover < movers_.size(); ++mover) {
    const SE3 world_from_rest = movers_[mover].motion(time_s);
    for (std::uint32_t number = movers_[mover].first; number < end_of(mover); ++number) {
      Primitive& primitive = result.primitives_[number];
      primitive.center = world_from_rest * primitive.center;
      primitive.world_from_local = world_from_rest.rotation().matrix() * primitive.world_from_local;
      primitive.aligned = primitive.world_from_local == Eigen::Matrix3d::Identity();
    }
  }
  return result;
}

namespace {

/// The nearest intersection among the solids that test() is called with.
class NearestIntersection {
 public:
  NearestIntersection(const std::vector<Primitive>& primitives, const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& direction, double limit)
      : primitives_(primitives), origin_(origin), direction_(direction), inverse_(detail::inverse_of(direction)) {
    best_.t = limit;
  }
  /// Returns the distance that the next solid has to undercut.
  double test(std::uint32_t number) {
    const Primitive& primitive = primitives_[number];
    const Intersection meeting =
        intersect(primitive, to_local(primitive, origin_ - primitive.center), direction_, inverse_);
    if (meeting.t < best_.t) {
      best_ = meeting;
      met_ = &primitive;
    }
    return best_.t;
  }
  void test(std::uint32_t first, std::uint32_t end) {
    for (std::uint32_t number = first; number < end; ++number) test(number);
  }
  double limit() const { return best_.t; }
  std::optional<RayHit> hit() const {
    if (met_ == nullptr) return std::nullopt;
    return RayHit{best_.t, met_->first_surface + static_cast<std::uint32_t>(best_.face),
                  origin_ + best_.t * direction_};
  }

 private:
  const std::vector<Primitive>& primitives_;
  const Eigen::Vector3d& origin_;
  const Eigen::Vector3d& direction_;
  Eigen::Vector3d inverse_;
  Intersection best_;
  const Primitive* met_ = nullptr;
};

void test_still(NearestIntersection& nearest, const BoundsTree& tree, std::uint32_t count,
                const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  if (tree.empty())
    nearest.test(0, count);
  else
    tree.visit(origin, direction, nearest.limit(), [&](std::uint32_t number) { return nearest.test(number); });
}

}  // namespace

std::optional<RayHit> Scene::trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                   double limit) const {
  NearestIntersection nearest(primitives_, origin, direction, limit);
  test_still(nearest, *tree_, still_count(), origin, direction);
  nearest.test(still_count(), static_cast<std::uint32_t>(primitives_.size()));
  return nearest.hit();
}

std::optional<RayHit> Scene::trace_beside(std::uint32_t primitive, const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction, double limit) const {
  NearestIntersection nearest(primitives_, origin, direction, limit);
  if (primitive < still_count()) test_still(nearest, *tree_, still_count(), origin, direction);
  for (std::size_t mover = 0; mover < movers_.size(); ++mover)
    if (primitive >= movers_[mover].first && primitive < end_of(mover))
      nearest.test(movers_[mover].first, end_of(mover));
  return nearest.hit();
}

FacePoint Scene::face_point(std::uint32_t surface, const Eigen::Vector3d& point) const {
  const Surface& face = (*surfaces_)[surface];
  return face_point_of(primitives_[face.primitive], face.face, point);
}

bool Scene::touches(const Eigen::Vector3d& center, double radius) const {
  for (const Primitive& primitive : primitives_) {
    const Eigen::Vector3d local = to_local(primitive, center - primitive.center);
    const Eigen::Vector3d outside = (local.cwiseAbs() - primitive.half).cwiseMax(0.0);
    if (outside.norm() < radius) return true;
  }
  return false;
}

std::size_t Scene::texture_bytes() const {
  std::size_t total = 0;
  for (const Surface& surface : *surfaces_) total += surface.texture.bytes() + surface.colors.bytes();
  return total;
}

}  // namespace rastro
