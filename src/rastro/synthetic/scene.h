// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/base/task_pool.h"
#include "rastro/math/se3.h"
#include "rastro/synthetic/bounds_tree.h"
#include "rastro/synthetic/paint/canvas.h"
#include "rastro/synthetic/texture.h"

namespace rastro {

enum class Shape : std::uint8_t {
  box,       ///< Faces in the order +x -x +y -y +z -z.
  quad,      ///< A rectangle in its local plane z = 0, visible from both sides.
  cylinder,  ///< Along local z: side, cap at +z, cap at -z.
  sphere,
};

/// A solid of the scene in its own frame, at its center.
struct Primitive {
  Shape shape = Shape::box;
  bool aligned = true;  ///< The rotation is the identity.
  Eigen::Matrix3d world_from_local = Eigen::Matrix3d::Identity();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< In the world, meters.
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< Half sizes along the local axes: radius, radius, half height of
                                                   ///< a cylinder; radii of a sphere.
  std::uint32_t first_surface = 0;                 ///< First surface of its faces, which are consecutive.
};

/// Material of a face. The painter draws the reflectance; light is multiplied in afterwards unless the face is a light
/// source.
struct Material {
  std::function<void(Canvas&, Random&)> paint;
  double texels_per_meter = 100.0;
  bool shines = false;
  float infrared = 1.0F;  ///< Visibility to a depth camera: 0 never, 1 always.
  /// Faces of one size with the same number are painted alike (doors of one make, panels of one wall); 0: each face its
  /// own.
  std::uint64_t likeness = 0;
};

/// One face, identified by a surface id.
struct Surface {
  std::uint32_t primitive = 0;
  int face = 0;
  double width = 0.0, height = 0.0;  ///< Meters, unrolled.
  Material material;
  Texture texture;
  ColorTexture colors;                    ///< Empty if all is gray.
  double texels_x = 0.0, texels_y = 0.0;  ///< Actual texels per meter.
};

/// First intersection of a ray origin + t * direction with a solid. With a direction of unit depth (x, y, 1) in a
/// camera, t is the depth.
struct RayHit {
  double t = 0.0;
  std::uint32_t surface = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< In the world, meters.
};

/// The face at a point: its texture coordinates and its local directions in the world.
struct FacePoint {
  double u = 0.0, v = 0.0;  ///< Meters from the upper left corner of the face.
  Eigen::Vector3d normal, along_u, along_v;
};

/// A rectangle of glass, thin and flat. Rays pass through it (no trace() hits it); color images show a weak reflection
/// on it, and depth cameras measure nothing or the surface behind.
struct GlassSheet {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::UnitX(), down = Eigen::Vector3d::UnitY();  ///< Full sides, perpendicular.

  /// Distance of the intersection along a ray, in lengths of `direction`; infinite if missed.
  double intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    const Eigen::Vector3d normal = right.cross(down);
    const double t = normal.dot(center - origin) / normal.dot(direction);
    const Eigen::Vector3d offset = origin + t * direction - center;
    const bool met = t > 0.0 && std::abs(offset.dot(right)) <= 0.5 * right.squaredNorm() &&
                     std::abs(offset.dot(down)) <= 0.5 * down.squaredNorm();
    return met ? t : std::numeric_limits<double>::infinity();
  }
};

/// Motion of an object: world_from_rest relative to the pose in which its solids were added. Must depend on the time
/// only.
using Motion = std::function<SE3(double time_s)>;

/// Textured solids with exact geometry. Copies share the textures.
class Scene {
 public:
  /// Rotated by `yaw` (radians) about the vertical unless a full rotation is given. Each returns the index of the
  /// primitive.
  std::uint32_t add_box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, const Material& material,
                        double yaw = 0.0);
  std::uint32_t add_cylinder(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius,
                             const Material& material);
  std::uint32_t add_sphere(const Eigen::Vector3d& center, double radius, const Material& material);
  /// Spanned by perpendicular full side vectors; `right` and `down` as seen from the front of its image.
  std::uint32_t add_quad(const Eigen::Vector3d& center, const Eigen::Vector3d& right, const Eigen::Vector3d& down,
                         const Material& material);
  void add_glass(const GlassSheet& sheet) { glass_.push_back(sheet); }
  const std::vector<GlassSheet>& glass() const { return glass_; }
  /// Replaces the material of one face of a primitive.
  void paint_face(std::uint32_t primitive, int face, const Material& material);
  /// The solids added from now on (until the next call) are one moving object, such as a car. Static solids are added
  /// first. The light on a moving object is that of the open; it shades nothing but itself.
  void begin_moving(Motion motion);

  /// Paints and lights all surfaces. The same images for any pool. `detail` scales the texels per meter of all
  /// materials; light is gathered every `light_spacing_m`.
  void bake(std::uint64_t seed, TaskPool& pool, double detail = 1.0, double light_spacing_m = 0.35);

  /// Builds the tree that finds solids near a ray, for scenes that are never painted; bake() does so too.
  void make_tree();

  /// Number of static solids; they come first.
  std::uint32_t still_count() const;
  bool moves() const { return !movers_.empty(); }
  /// The scene with all objects at their poses at `time_s`. Only for a scene whose moving objects are at rest.
  Scene at(double time_s) const;

  /// First solid hit for t in (0, limit): the exact ground truth of the images. nullopt if there is none.
  std::optional<RayHit> trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                              double limit = 1e9) const;
  /// The same among the static solids other than `primitive`.
  std::optional<RayHit> trace_beside(std::uint32_t primitive, const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction, double limit) const;
  /// Position of `point` of the surface on its face.
  FacePoint face_point(std::uint32_t surface, const Eigen::Vector3d& point) const;
  /// Whether a ball touches or is inside any solid (boxes and cylinders by their oriented box).
  bool touches(const Eigen::Vector3d& center, double radius) const;

  const std::vector<Primitive>& primitives() const { return primitives_; }
  const std::vector<Surface>& surfaces() const { return *surfaces_; }
  std::size_t texture_bytes() const;

 private:
  struct Mover {
    std::uint32_t first = 0;  ///< Its solids end at the next mover's first one.
    Motion motion;
  };

  std::uint32_t add(Primitive primitive, const Material& material);
  std::uint32_t end_of(std::size_t mover) const;
  std::vector<Primitive> primitives_;
  std::shared_ptr<std::vector<Surface>> surfaces_ = std::make_shared<std::vector<Surface>>();
  std::vector<Mover> movers_;
  std::vector<GlassSheet> glass_;
  /// Of all static solids after bake(); empty before.
  std::shared_ptr<const BoundsTree> tree_ = std::make_shared<const BoundsTree>();
};

}  // namespace rastro
