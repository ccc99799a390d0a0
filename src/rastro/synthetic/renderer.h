// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "rastro/base/task_pool.h"
#include "rastro/camera/camera.h"
#include "rastro/image/image.h"
#include "rastro/math/se3.h"
#include "rastro/synthetic/scene.h"
#include "rastro/synthetic/sensor_model.h"

namespace rastro {

constexpr std::uint32_t no_surface = 0xFFFFFFFF;

struct RenderedFrame {
  GrayImage gray;
  DepthImage
      depth;  ///< Exact depth along the optical axis at each pixel's center, meters; 0 where the ray hits nothing.
  Image<std::uint32_t> surface;  ///< Surface at each pixel's center; no_surface where there is none.
  ColorImage color;              ///< Only on request; `gray` is then computed from it.
};

/// Light that falls on a point of a surface (world, meters) with a unit normal towards the camera: a factor on the
/// painted and lit texture. Must depend on its arguments only.
using LightField = std::function<float(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double time_s)>;

/// Casts one ray per pixel, more along the edges of solids, in small tiles with lists of the solids they may show. The
/// scene must outlive the renderer. Rendering does not modify the scene and may run for several frames at once.
class Renderer {
 public:
  /// Throws Error for a camera without size or whose distortion cannot be inverted somewhere in the image.
  /// Without a light field the light is that of the baked textures at all times.
  Renderer(const Scene& scene, const Camera& camera, LightField light = {});

  /// The same bytes for any pool. Moving objects are at their poses at `time_s`.
  RenderedFrame render(const SE3& world_from_camera, const SensorModel& sensor, const ShutterMotion& shutter,
                       std::uint64_t noise_seed, TaskPool& pool, double time_s = 0.0, bool in_color = false) const;
  /// Only depth and surfaces.
  RenderedFrame cast(const SE3& world_from_camera, TaskPool& pool, double time_s = 0.0) const;

  const Scene& scene() const { return *scene_; }

  const Camera& camera() const { return camera_; }
  const LightField& light() const { return light_; }
  /// Direction of a pixel's center in the camera, with z = 1.
  Eigen::Vector3d ray(int x, int y) const {
    const std::size_t pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) + static_cast<std::size_t>(x);
    return {rays_[pixel].x(), rays_[pixel].y(), 1.0};
  }

 private:
  const Scene* scene_;
  Camera camera_;
  LightField light_;
  std::vector<Eigen::Vector2d> rays_;
};

}  // namespace rastro
