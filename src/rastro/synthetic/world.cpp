// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/world.h"

#include <cmath>

#include "rastro/base/random.h"

namespace rastro {
namespace {

class WorldSource : public Source {
 public:
  WorldSource(const World& world, std::int64_t frames, int threads) : world_(world), pool_(threads) {
    info_.path = world.name();
    info_.format = "synthetic";
    info_.cameras.push_back({"cam0", world.camera(), world.body_from_camera(), "generated"});
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
    frame.image = std::move(rendered.grey);
    frame.colour = std::move(rendered.colour);
    frame.depth = std::move(rendered.depth);
    frame.depth_stamp = frame.stamp;
    ++next_;
    return frame;
  }

 private:
  const World& world_;
  TaskPool pool_;
  SourceInfo info_;
  std::int64_t next_ = 0;
};

}  // namespace

World::World(std::unique_ptr<const Scene> scene, Parts parts)
    : scene_(std::move(scene)), parts_(std::move(parts)), renderer_(*scene_, parts_.camera) {}

TimeNs World::stamp(std::int64_t frame) const {
  return parts_.first_stamp + static_cast<TimeNs>(std::llround(static_cast<double>(frame) * 1e9 / parts_.rate_hz));
}

SE3 World::world_from_camera(std::int64_t frame) const {
  return parts_.path.world_from_camera(static_cast<double>(frame) / parts_.rate_hz);
}

Scene World::scene_at(std::int64_t frame) const { return scene_->at(static_cast<double>(frame) / parts_.rate_hz); }

RenderedFrame World::render(std::int64_t frame, TaskPool& pool) const {
  const double time = static_cast<double>(frame) / parts_.rate_hz;
  const SensorModel sensor = parts_.sensor(time);
  // The picture's pose is that of the middle of the exposure.
  const double half = 0.5 * sensor.exposure_time_s;
  const SE3 begin_from_end = world_from_camera_at(time - half).inverse() * world_from_camera_at(time + half);
  return renderer_.render(world_from_camera_at(time), sensor, {begin_from_end.log()},
                          seed_for(parts_.seed, static_cast<std::uint64_t>(frame)), pool, time, parts_.in_colour);
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
  // A millimetre at ten metres before the point itself: its own surface must not hide it through rounding.
  view.visible =
      !scene_at(frame).trace(pose.translation(), point_in_world - pose.translation(), 1.0 - 1e-4).has_value();
  return view;
}

std::unique_ptr<Source> synthetic_source(const World& world, std::int64_t frames, int threads) {
  return std::make_unique<WorldSource>(world, frames, threads);
}

}  // namespace rastro
