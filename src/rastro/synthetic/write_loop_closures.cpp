// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/write_loop_closures.h"

#include <fmt/format.h>

#include <cmath>

#include "rastro/synthetic/recording_files.h"

namespace rastro {
namespace {

constexpr int columns = 12, rows = 9;  // Rays that sample an image.

/// Surface points hit by the rays of a frame.
std::vector<Eigen::Vector3d> points_of(const World& world, std::int64_t frame, const Scene& scene, double farthest_m) {
  const Camera& camera = world.camera();
  const SE3 pose = world.world_from_camera(frame);
  std::vector<Eigen::Vector3d> points;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const auto ray = camera.unproject({camera.width * (column + 0.5) / columns, camera.height * (row + 0.5) / rows});
      if (!ray) continue;
      const auto hit =
          scene.trace(pose.translation(), pose.rotation().matrix() * Eigen::Vector3d(ray->x(), ray->y(), 1.0));
      if (hit && hit->t <= farthest_m) points.push_back(hit->point);
    }
  return points;
}

bool sees(const World& world, const Scene& scene, const SE3& pose, const Eigen::Vector3d& point) {
  const Camera& camera = world.camera();
  const auto pixel = camera.project(pose.inverse() * point);
  if (!pixel || !(pixel->x() >= -0.5 && pixel->y() >= -0.5 && pixel->x() < camera.width - 0.5 &&
                  pixel->y() < camera.height - 0.5))
    return false;
  return !scene.trace(pose.translation(), point - pose.translation(), 1.0 - 1e-4).has_value();
}

double angle_between(const SE3& a, const SE3& b) {
  const Eigen::Vector3d axis_a = a.rotation() * Eigen::Vector3d::UnitZ(),
                        axis_b = b.rotation() * Eigen::Vector3d::UnitZ();
  return std::acos(std::clamp(axis_a.dot(axis_b), -1.0, 1.0));
}

Eigen::Vector3d motion(const World& world, std::int64_t frame) {
  return world.world_from_camera(frame + 1).translation() - world.world_from_camera(frame - 1).translation();
}

/// Frames used, with their scenes.
struct UsedFrame {
  std::int64_t frame;
  SE3 pose;
  Scene scene;
};

}  // namespace

std::vector<TrueLoopClosure> true_loop_closures(const World& world, std::int64_t frames,
                                                const LoopClosureSearch& search) {
  std::vector<UsedFrame> used_frames;
  for (std::int64_t frame = 0; frame < frames; frame += search.step)
    used_frames.push_back({frame, world.world_from_camera(frame), world.scene_at(frame)});
  std::vector<TrueLoopClosure> loop_closures;
  for (const UsedFrame& late : used_frames) {
    TrueLoopClosure best;
    std::vector<Eigen::Vector3d> points;
    for (const UsedFrame& early : used_frames) {
      if (early.frame + search.gap > late.frame) break;
      const double distance = (early.pose.translation() - late.pose.translation()).norm();
      if (distance > search.farthest_m || angle_between(early.pose, late.pose) > search.widest_rad) continue;
      if (points.empty()) points = points_of(world, late.frame, late.scene, search.farthest_point_m);
      int shared = 0;
      for (const Eigen::Vector3d& point : points) shared += sees(world, early.scene, early.pose, point) ? 1 : 0;
      const double overlap = static_cast<double>(shared) / (columns * rows);
      if (overlap <= best.overlap) continue;
      best = {late.frame, early.frame, overlap, distance,
              motion(world, late.frame).dot(motion(world, early.frame)) < 0.0};
    }
    if (best.overlap >= search.least_overlap) loop_closures.push_back(best);
  }
  return loop_closures;
}

void write_loop_closures(const World& world, std::int64_t frames, const std::filesystem::path& folder) {
  TextFile file(
      folder / "closures.yaml",
      "# True loop closures from the exact scene: overlap (share of the image), meters between the two positions\n"
      "# of the camera, and the direction of its motion.\n"
      "closures:\n");
  for (const TrueLoopClosure& loop_closure : true_loop_closures(world, frames))
    file.write(fmt::format(
        "  - {{frame: {}, earlier: {}, stamp: {}, earlier_stamp: {}, overlap: {:.2f}, "
        "distance_m: {:.2f}, direction: {}}}\n",
        loop_closure.frame, loop_closure.earlier, world.stamp(loop_closure.frame), world.stamp(loop_closure.earlier),
        loop_closure.overlap, loop_closure.distance_m, loop_closure.opposite ? "opposite" : "same"));
}

}  // namespace rastro
