// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "rastro/base/task_pool.h"
#include "rastro/base/time.h"
#include "rastro/camera/camera.h"
#include "rastro/math/se3.h"
#include "rastro/sensor/source.h"
#include "rastro/synthetic/kinect_model.h"
#include "rastro/synthetic/named_length.h"
#include "rastro/synthetic/path.h"
#include "rastro/synthetic/renderer.h"
#include "rastro/synthetic/scene.h"
#include "rastro/synthetic/sensor_model.h"

namespace rastro {

/// View of a world point in one frame.
struct PointView {
  bool inside = false;                              ///< It projects into the image.
  bool visible = false;                             ///< And no nearer surface occludes it.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< Undefined if not inside.
};

/// A generated world with a moving camera. Any frame can be rendered independently, in any order, and everything about
/// it is known exactly. Frames are numbered from 0 and never end. Const members are thread-safe.
class World {
 public:
  struct Parts {
    std::string name;
    Camera camera;
    CameraPath path;
    std::function<SensorModel(double time_s)> sensor;
    double rate_hz = 20.0;
    TimeNs first_stamp = 0;
    std::uint64_t seed = 1;
    SE3 body_from_camera;
    bool in_color = false;                             ///< Frames have color images, and gray ones computed from them.
    std::optional<KinectModel> kinect = std::nullopt;  ///< Model of its own depth camera, if it has one.
    std::vector<NamedLength> lengths = {};             ///< Its known lengths.
    /// Pose of a second camera of the same type, if there is one.
    std::optional<SE3> left_from_right = std::nullopt;
    LightField light = {};  ///< Light that changes with time and place; empty: only what is baked.
  };
  World(std::unique_ptr<const Scene> scene, Parts parts);

  const std::string& name() const { return parts_.name; }
  /// Moving objects are at rest; scene_at() places them.
  const Scene& scene() const { return *scene_; }
  Scene scene_at(std::int64_t frame) const;
  const Camera& camera() const { return parts_.camera; }
  const SE3& body_from_camera() const { return parts_.body_from_camera; }
  double rate_hz() const { return parts_.rate_hz; }
  std::uint64_t seed() const { return parts_.seed; }
  TimeNs stamp(std::int64_t frame) const;
  SE3 world_from_camera(std::int64_t frame) const;
  SE3 world_from_camera_at(double time_s) const { return parts_.path.world_from_camera(time_s); }

  const std::optional<KinectModel>& kinect() const { return parts_.kinect; }
  const std::vector<NamedLength>& lengths() const { return parts_.lengths; }
  /// Time of a frame from the start.
  double time_of(std::int64_t frame) const { return static_cast<double>(frame) / parts_.rate_hz; }

  RenderedFrame render(std::int64_t frame, TaskPool& pool) const;
  const std::optional<SE3>& left_from_right() const { return parts_.left_from_right; }
  /// The same moment in the right camera. Only for a world that has one.
  RenderedFrame render_right(std::int64_t frame, TaskPool& pool) const;
  /// Exact depth and surfaces at any time, without rendering an image.
  RenderedFrame depth_at(double time_s, TaskPool& pool) const {
    return renderer_.cast(world_from_camera_at(time_s), pool, time_s);
  }
  const Renderer& renderer() const { return renderer_; }

  /// The exact surface point at a pixel; nullopt outside the image or where the ray hits nothing.
  std::optional<RayHit> surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const;
  /// Projection and visibility of a point on a surface.
  PointView view_of(std::int64_t frame, const Eigen::Vector3d& point_in_world) const;

 private:
  RenderedFrame render_from(const SE3& left_from_camera, std::int64_t frame, std::uint64_t noise_seed,
                            TaskPool& pool) const;

  std::unique_ptr<const Scene> scene_;
  Parts parts_;
  Renderer renderer_;
};

/// The first `frames` frames as a source with ground truth of the camera, without any file; of both cameras if `stereo`
/// is set and the world has two. The world must outlive the source.
std::unique_ptr<Source> synthetic_source(const World& world, std::int64_t frames, int threads = 1, bool stereo = false);

}  // namespace rastro
