// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/write_loop_closures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rastro/synthetic/recording_files.h"

namespace rastro {
namespace {

constexpr int ray_columns = 12, ray_rows = 9;  // Rays that sample an image.

/// Surface points hit by the rays of a frame.
std::vector<Eigen::Vector3d> points_of(const World& world, std::int64_t frame, const Scene& scene, double farthest_m) {
  const Camera& camera = world.camera();
  const SE3 pose = world.world_from_camera(frame);
  std::vector<Eigen::Vector3d> points;
  for (int row = 0; row < ray_rows; ++row)
    for (int column = 0; column < ray_columns; ++column) {
      const auto ray =
          camera.unproject({camera.width * (column + 0.5) / ray_columns, camera.height * (row + 0.5) / ray_rows});
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

struct UsedFrame {
  std::int64_t number;  ///< In the recording.
  std::int64_t frame;   ///< Of the world.
  SE3 pose;
};

std::vector<UsedFrame> used_frames(const World& world, std::int64_t frames, const FrameSelection& selection,
                                   double step_s) {
  const auto every = static_cast<double>(selection.every);
  const auto step = std::max<std::int64_t>(1, std::llround(step_s * world.rate_hz() / every));
  std::vector<UsedFrame> used;
  for (std::int64_t number = 0; number < frames; number += step) {
    const std::int64_t frame = selection.frame(number);
    used.push_back({number, frame, world.world_from_camera(frame)});
  }
  return used;
}

/// The one of largest overlap among the frames before `late`.
TrueLoopClosure best_earlier(const World& world, const std::vector<UsedFrame>& used, const UsedFrame& late,
                             const LoopClosureSearch& search) {
  TrueLoopClosure best;
  std::vector<Eigen::Vector3d> points;
  const auto gap = static_cast<std::int64_t>(std::llround(search.gap_s * world.rate_hz()));
  for (const UsedFrame& early : used) {
    if (early.frame + gap > late.frame) break;
    const double distance = (early.pose.translation() - late.pose.translation()).norm();
    if (distance > search.farthest_m || angle_between(early.pose, late.pose) > search.widest_rad) continue;
    if (points.empty()) points = points_of(world, late.frame, world.scene_at(late.frame), search.farthest_point_m);
    const Scene scene = world.scene_at(early.frame);
    int shared = 0;
    for (const Eigen::Vector3d& point : points) shared += sees(world, scene, early.pose, point) ? 1 : 0;
    const double overlap = static_cast<double>(shared) / (ray_columns * ray_rows);
    if (overlap <= best.overlap) continue;
    best = {late.number, early.number, overlap, distance,
            motion(world, late.frame).dot(motion(world, early.frame)) < 0.0};
  }
  return best;
}

}  // namespace

std::vector<TrueLoopClosure> true_loop_closures(const World& world, std::int64_t frames,
                                                const FrameSelection& selection, TaskPool& pool,
                                                const LoopClosureSearch& search) {
  const std::vector<UsedFrame> used = used_frames(world, frames, selection, search.step_s);
  std::vector<TrueLoopClosure> best(used.size());
  pool.for_chunks(0, static_cast<int>(used.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      best[i] = best_earlier(world, used, used[i], search);
  });
  std::erase_if(best, [&](const TrueLoopClosure& one) { return one.overlap < search.least_overlap; });
  return best;
}

void write_loop_closures(const World& world, std::int64_t frames, const FrameSelection& selection,
                         const std::filesystem::path& folder, TaskPool& pool) {
  TextFile file(
      folder / "closures.yaml",
      "# True loop closures from the exact scene: overlap (share of the image), meters between the two positions\n"
      "# of the camera, and the direction of its motion.\n"
      "closures:\n");
  for (const TrueLoopClosure& loop_closure : true_loop_closures(world, frames, selection, pool))
    file.write(
        fmt::format("  - {{frame: {}, earlier: {}, stamp: {}, earlier_stamp: {}, overlap: {:.2f}, "
                    "distance_m: {:.2f}, direction: {}}}\n",
                    loop_closure.frame, loop_closure.earlier, world.stamp(selection.frame(loop_closure.frame)),
                    world.stamp(selection.frame(loop_closure.earlier)), loop_closure.overlap, loop_closure.distance_m,
                    loop_closure.opposite ? "opposite" : "same"));
}

}  // namespace rastro
