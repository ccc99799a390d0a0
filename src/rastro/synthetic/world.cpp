// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/world.h"

#include <cmath>

#include "rastro/base/error.h"
#include "rastro/base/random.h"

namespace rastro {
namespace {

constexpr std::uint64_t right_noise = 31;

class WorldSource : public Source {
 public:
  WorldSource(const World& world, std::int64_t frames, int threads, bool stereo)
      : world_(world), pool_(threads), stereo_(stereo && world.left_from_right()) {
    info_.path = world.name();
    info_.format = "synthetic";
    info_.cameras.push_back({"cam0", world.camera(), world.body_from_camera(), "generated"});
    if (stereo_) {
      const SE3 body_from_right = world.body_from_camera() * *world.left_from_right();
      info_.cameras.push_back({"cam1", world.camera(), body_from_right, "generated"});
      info_.left_from_right = world.left_from_right();
      info_.has_right = true;
    }
    info_.frame_count = frames;
    info_.ground_truth_frame = "camera";
    info_.ground_truth_file = "generated";
    for (std::int64_t frame = 0; frame < frames; ++frame)
      info_.ground_truth.push_back({world.stamp(frame), world.world_from_camera(frame)});
  }
  const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    if (next_ >= info_.frame_count) return std::nullopt;
    RenderedFrame rendered = world_.render(next_, pool_);
    Frame frame;
    frame.index = next_;
    frame.stamp = world_.stamp(next_);
    frame.name = world_.name() + " frame " + std::to_string(next_);
    frame.image = std::move(rendered.gray);
    if (stereo_) frame.right = world_.render_right(next_, pool_).gray;
    frame.color = std::move(rendered.color);
    frame.depth = std::move(rendered.depth);
    frame.depth_stamp = frame.stamp;
    ++next_;
    return frame;
  }

 private:
  const World& world_;
  TaskPool pool_;
  bool stereo_;
  SourceInfo info_;
  std::int64_t next_ = 0;
};

}  // namespace

World::World(std::unique_ptr<const Scene> scene, Parts parts)
    : scene_(std::move(scene)), parts_(std::move(parts)), renderer_(*scene_, parts_.camera, parts_.light) {}

TimeNs World::stamp(std::int64_t frame) const {
  return parts_.first_stamp + static_cast<TimeNs>(std::llround(static_cast<double>(frame) * 1e9 / parts_.rate_hz));
}

SE3 World::world_from_camera(std::int64_t frame) const {
  return parts_.path.world_from_camera(static_cast<double>(frame) / parts_.rate_hz);
}

Scene World::scene_at(std::int64_t frame) const { return scene_->at(static_cast<double>(frame) / parts_.rate_hz); }

RenderedFrame World::render(std::int64_t frame, TaskPool& pool) const {
  return render_from(SE3(), frame, seed_for(parts_.seed, static_cast<std::uint64_t>(frame)), pool);
}

RenderedFrame World::render_right(std::int64_t frame, TaskPool& pool) const {
  RASTRO_CHECK(parts_.left_from_right, "the world has a right camera");
  const std::uint64_t noise = seed_for(seed_for(parts_.seed, right_noise), static_cast<std::uint64_t>(frame));
  return render_from(*parts_.left_from_right, frame, noise, pool);
}

RenderedFrame World::render_from(const SE3& left_from_camera, std::int64_t frame, std::uint64_t noise_seed,
                                 TaskPool& pool) const {
  const double time = static_cast<double>(frame) / parts_.rate_hz;
  const SensorModel sensor = parts_.sensor(time);
  // The pose is that of the middle of the exposure.
  const double half = 0.5 * sensor.exposure_time_s;
  const SE3 begin = world_from_camera_at(time - half) * left_from_camera;
  const SE3 end = world_from_camera_at(time + half) * left_from_camera;
  return renderer_.render(world_from_camera_at(time) * left_from_camera, sensor, {(begin.inverse() * end).log()},
                          noise_seed, pool, time, parts_.in_color);
}

std::optional<RayHit> World::surface_at(std::int64_t frame, const Eigen::Vector2d& pixel) const {
  const Camera& camera = parts_.camera;
  if (!(pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera.width - 0.5 && pixel.y() < camera.height - 0.5))
    return std::nullopt;
  const std::optional<Eigen::Vector2d> ray = camera.unproject(pixel);
  if (!ray) return std::nullopt;
  const SE3 pose = world_from_camera(frame);
  return scene_at(frame).trace(pose.translation(), pose.rotation().matrix() * Eigen::Vector3d(ray->x(), ray->y(), 1.0));
}

PointView World::view_of(std::int64_t frame, const Eigen::Vector3d& point_in_world) const {
  const Camera& camera = parts_.camera;
  const SE3 pose = world_from_camera(frame);
  const std::optional<Eigen::Vector2d> pixel = camera.project(pose.inverse() * point_in_world);
  PointView view;
  if (!pixel || !(pixel->x() >= -0.5 && pixel->y() >= -0.5 && pixel->x() < camera.width - 0.5 &&
                  pixel->y() < camera.height - 0.5))
    return view;
  view.inside = true;
  view.pixel = *pixel;
  // A millimeter at ten meters in front of the point: rounding must not let its own surface occlude it.
  view.visible =
      !scene_at(frame).trace(pose.translation(), point_in_world - pose.translation(), 1.0 - 1e-4).has_value();
  return view;
}

std::unique_ptr<Source> synthetic_source(const World& world, std::int64_t frames, int threads, bool stereo) {
  return std::make_unique<WorldSource>(world, frames, threads, stereo);
}

}  // namespace rastro
