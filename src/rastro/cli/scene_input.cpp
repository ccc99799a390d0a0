// SPDX-License-Identifier: Apache-2.0
#include "rastro/cli/scene_input.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "rastro/base/error.h"
#include "rastro/cli/run_notes.h"
#include "rastro/cli/scene_lengths.h"
#include "rastro/viewer/run_record.h"
#include "rastro/viewer/scene_writer.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr double level = 1e-6;

Map without_keyframes(const ExportInput& input) {
  if (input.trajectory.empty()) throw Error("has no poses", input.path, "there is nothing to show");
  return {};
}

/// Poses alone do not say what they are of: a planar robot where they stay level, with z up, else a camera.
void guess_up(const Trajectory& trajectory, ViewScene& scene) {
  bool planar = true;
  for (const StampedPose& pose : trajectory) {
    const SO3& rotation = pose.world_from_body.rotation();
    const double height = (pose.world_from_body.translation() - trajectory.front().world_from_body.translation()).z();
    planar = planar && (rotation * Eigen::Vector3d::UnitZ()).z() > 1.0 - level && std::abs(height) < level;
  }
  scene.planar = planar;
  scene.up = up_of(trajectory, planar);
}

ViewScene whole_scene_of(const ExportInput& input, const ViewSceneOptions& options, TaskPool& pool,
                         const MapProgress& progress, const std::string& objects) {
  ViewScene scene = view_scene_of(input, notes_of_run(input), options, pool, progress);
  scene.lengths = lengths_of(input, objects, pool);
  return scene;
}

}  // namespace

std::array<double, 3> up_of(const Trajectory& trajectory, bool planar) {
  if (planar) return {0.0, 0.0, 1.0};
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : trajectory) up -= pose.world_from_body.rotation() * Eigen::Vector3d::UnitY();
  if (up.norm() < level) up = -Eigen::Vector3d::UnitY();
  up.normalize();
  return {up.x(), up.y(), up.z()};
}

std::string scene_name(const std::string& path) {
  std::error_code ignored;
  fs::path whole = fs::absolute(path, ignored).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();  // it ended with a slash
  if (fs::is_directory(whole, ignored)) return whole.filename().string();
  // Every run has its map and its trajectory under these names.
  const bool of_run = whole.filename() == "map.rastro" || whole.filename() == "trajectory.txt";
  return (of_run ? whole.parent_path().filename() : whole.stem()).string();
}

ViewScene view_scene_of(const ExportInput& input, RunRecord record, const ViewSceneOptions& options, TaskPool& pool,
                        const MapProgress& progress) {
  const bool mapped = input.map && !(input.map->keyframes.empty() && input.map->frames.empty());
  ViewScene scene = build_scene(mapped ? *input.map : without_keyframes(input), options, pool, progress);
  if (!mapped) guess_up(input.trajectory, scene);
  // The trajectory is that of the first submap.
  if (options.submap > 0) record.trajectory.clear();
  add_run(record, scene);
  scene.title = scene_name(input.path);
  return scene;
}

NamedScene scene_of(const ExportInput& input, const ViewSceneOptions& options, TaskPool& pool,
                    const MapProgress& progress, const std::string& objects) {
  const ViewScene scene = whole_scene_of(input, options, pool, progress, objects);
  return {scene.title, scene_bytes(scene)};
}

NamedScene served_scene_of(const ExportInput& input, const ViewSceneOptions& options, TaskPool& pool,
                           const MapProgress& progress, const TileProgress& tiling, const std::string& objects) {
  return in_tiles(whole_scene_of(input, options, pool, progress, objects), tiling);
}

NamedScene in_tiles(ViewScene scene, const TileProgress& progress) {
  constexpr std::size_t most_at_once = 1'000'000;
  auto tile_block = tile_large_layers(scene, most_at_once, progress);
  NamedScene named{scene.title, scene_bytes(scene)};
  named.tile_block = std::move(tile_block);
  return named;
}

ViewSceneOptions scene_options(const SceneFlags& flags, int submap, std::size_t default_points) {
  constexpr std::int64_t most_points = 50'000'000;
  ViewSceneOptions options;
  options.submap = submap;
  options.mesh = flags.mesh;
  options.octree = flags.octree;
  options.max_points = default_points;
  if (!flags.points) return options;
  if (*flags.points < 1 || *flags.points > most_points)
    throw Error(fmt::format("{} is out of range", *flags.points), "--points", fmt::format("give 1 to {}", most_points));
  options.max_points = static_cast<std::size_t>(*flags.points);
  return options;
}

}  // namespace rastro::cli
