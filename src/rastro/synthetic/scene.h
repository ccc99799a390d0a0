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
  quad,      ///< A rectangle in its local plane z = 0, seen from both sides.
  cylinder,  ///< Along local z: side, cap at +z, cap at -z.
  sphere,
};

/// A solid of the scene in a frame of its own at its centre.
struct Primitive {
  Shape shape = Shape::box;
  bool aligned = true;  ///< The rotation is the identity.
  Eigen::Matrix3d world_from_local = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< In the world, metres.
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< Half sizes along the local axes: radius, radius, half height of
                                                   ///< a cylinder; radii of a sphere.
  std::uint32_t first_surface = 0;                 ///< Its faces are consecutive surfaces from here on.
};

/// How a face is painted. The painter draws the reflectance; light is multiplied in afterwards unless the face shines
/// itself.
struct Material {
  std::function<void(Canvas&, Random&)> paint;
  double texels_per_metre = 100.0;
  bool shines = false;
  float infrared = 1.0F;  ///< How well a depth camera sees it: 0 never, 1 always.
};

/// One face: what a surface id stands for.
struct Surface {
  std::uint32_t primitive = 0;
  int face = 0;
  double width = 0.0, height = 0.0;  ///< Metres, unrolled.
  Material material;
  Texture texture;
  ColourTexture colours;                  ///< Empty where all is grey.
  double texels_x = 0.0, texels_y = 0.0;  ///< Texels per metre as made.
};

/// Where a ray origin + t * direction first meets a solid. With a direction of unit depth (x, y, 1) in a camera, t is
/// the depth.
struct RayHit {
  double t = 0.0;
  std::uint32_t surface = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< In the world, metres.
};

/// The face at a point: its place in the texture and its local directions in the world.
struct FacePoint {
  double u = 0.0, v = 0.0;  ///< Metres from the upper left corner of the face.
  Eigen::Vector3d normal, along_u, along_v;
};

/// A rectangle of glass, thin and flat. Rays of sight go through it (it is part of no trace()); pictures in colour show
/// a weak reflection on it, and depth cameras see nothing or what lies behind.
struct GlassSheet {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::UnitX(), down = Eigen::Vector3d::UnitY();  ///< Full sides, at right angles.

  /// How far along a ray it is met, in lengths of `direction`; infinite where it is missed.
  double meet(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    const Eigen::Vector3d normal = right.cross(down);
    const double t = normal.dot(centre - origin) / normal.dot(direction);
    const Eigen::Vector3d place = origin + t * direction - centre;
    const bool met = t > 0.0 && std::abs(place.dot(right)) <= 0.5 * right.squaredNorm() &&
                     std::abs(place.dot(down)) <= 0.5 * down.squaredNorm();
    return met ? t : std::numeric_limits<double>::infinity();
  }
};

/// Where a thing that moves is: world_from_rest of the place where its solids were added. Must depend on the time only.
using Motion = std::function<SE3(double time_s)>;

/// Textured solids with exact geometry. Copies share the textures.
class Scene {
 public:
  /// Rotated by `yaw` (radians) about the vertical unless a full rotation is given. Each returns the primitive's
  /// number.
  std::uint32_t add_box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, const Material& material,
                        double yaw = 0.0);
  std::uint32_t add_cylinder(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius,
                             const Material& material);
  std::uint32_t add_sphere(const Eigen::Vector3d& centre, double radius, const Material& material);
  /// Spanned by full side vectors at right angles; `right` and `down` as the picture on it is seen from its front.
  std::uint32_t add_quad(const Eigen::Vector3d& centre, const Eigen::Vector3d& right, const Eigen::Vector3d& down,
                         const Material& material);
  void add_glass(const GlassSheet& sheet) { glass_.push_back(sheet); }
  const std::vector<GlassSheet>& glass() const { return glass_; }
  /// Replaces the material of one face of a primitive.
  void paint_face(std::uint32_t primitive, int face, const Material& material);
  /// The solids added from now on are one thing that moves (until the next call), as a car does. What stands still is
  /// added first. Light on a moving thing is that of the open; it darkens nothing but itself.
  void begin_moving(Motion motion);

  /// Paints and lights all surfaces. The same pictures for any pool. `detail` scales the texels per metre of all
  /// materials; light is gathered every `light_spacing_m`.
  void bake(std::uint64_t seed, TaskPool& pool, double detail = 1.0, double light_spacing_m = 0.35);

  /// Makes the tree that finds solids near a ray, for scenes that are never painted; bake() does so too.
  void make_tree();

  /// How many solids never move; they come first.
  std::uint32_t still_count() const;
  bool moves() const { return !movers_.empty(); }
  /// The scene with everything where it is at `time_s`. Only of a scene whose moving things are at rest.
  Scene at(double time_s) const;

  /// First solid met for t in (0, limit): the exact truth that pictures are made from. nullopt when there is none.
  std::optional<RayHit> trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                              double limit = 1e9) const;
  /// The same among the solids that never move away from solid `primitive`.
  std::optional<RayHit> trace_beside(std::uint32_t primitive, const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction, double limit) const;
  /// Where `point` of the surface lies on its face.
  FacePoint face_point(std::uint32_t surface, const Eigen::Vector3d& point) const;
  /// Whether a ball touches or is inside any solid (boxes and cylinders by their oriented box).
  bool touches(const Eigen::Vector3d& centre, double radius) const;

  const std::vector<Primitive>& primitives() const { return primitives_; }
  const std::vector<Surface>& surfaces() const { return *surfaces_; }
  std::size_t texture_bytes() const;

 private:
  struct Mover {
    std::uint32_t first = 0;  ///< Its solids go on to the next mover's first one.
    Motion motion;
  };

  std::uint32_t add(Primitive primitive, const Material& material);
  std::uint32_t end_of(std::size_t mover) const;
  std::vector<Primitive> primitives_;
  std::shared_ptr<std::vector<Surface>> surfaces_ = std::make_shared<std::vector<Surface>>();
  std::vector<Mover> movers_;
  std::vector<GlassSheet> glass_;
  /// Of all solids that stand still once bake() has run; empty while there are still some to come.
  std::shared_ptr<const BoundsTree> tree_ = std::make_shared<const BoundsTree>();
};

}  // namespace rastro
