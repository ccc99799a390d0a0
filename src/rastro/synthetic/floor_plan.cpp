// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/floor_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <numbers>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/synthetic/recording_files.h"

namespace rastro {
namespace {

using Eigen::Vector2d;

constexpr double skin_m = 0.001;  // A wall on the border of two cells belongs to the one behind it.

Vector2d local_corner(const Primitive& solid, double x, double y) {
  const Eigen::Vector3d corner =
      solid.center +
      solid.world_from_local * Eigen::Vector3d(x * (solid.half.x() - skin_m), y * (solid.half.y() - skin_m), 0.0);
  return corner.head<2>();
}

/// The outline of a solid at the laser's height, slightly inside; empty if it does not reach that height.
std::vector<Vector2d> outline_at(const Primitive& solid, double height_m) {
  if (solid.shape == Shape::quad || std::abs(height_m - solid.center.z()) > solid.half.z()) return {};
  if (solid.shape == Shape::box)
    return {local_corner(solid, 1, 1), local_corner(solid, -1, 1), local_corner(solid, -1, -1),
            local_corner(solid, 1, -1)};
  constexpr int corners = 24;
  std::vector<Vector2d> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    outline.push_back(local_corner(solid, std::cos(angle), std::sin(angle)));
  }
  return outline;
}

using Outlines = std::vector<std::vector<Vector2d>>;

Outlines all_outlines(const LaserWorld& world) {
  Outlines outlines;
  const auto& solids = world.scene->primitives();
  for (std::uint32_t number = 0; number < world.scene->still_count(); ++number) {
    auto outline = outline_at(solids[number], world.laser.height_m);
    if (!outline.empty()) outlines.push_back(std::move(outline));
  }
  for (const GlassPane& pane : world.panes) outlines.push_back({pane.from, pane.to});
  return outlines;
}

FloorPlan empty_plan(const Outlines& outlines, double resolution) {
  RASTRO_CHECK(!outlines.empty(), "a plan needs a building with walls");
  Vector2d low = outlines.front().front(), high = low;
  for (const auto& outline : outlines)
    for (const Vector2d& corner : outline) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  constexpr double margin_m = 0.5;
  FloorPlan plan;
  plan.resolution = resolution;
  // The world's origin is a corner of four cells.
  for (int axis = 0; axis < 2; ++axis) plan.low[axis] = resolution * std::floor((low[axis] - margin_m) / resolution);
  const Vector2d size = (high - plan.low).array() + margin_m;
  plan.cells = Image<PlanCell>(static_cast<int>(std::ceil(size.x() / resolution)),
                               static_cast<int>(std::ceil(size.y() / resolution)));
  return plan;
}

/// Marks the cells that the beams of one scan pass, up to the solid that they hit.
void mark_seen(const LaserWorld& world, std::int64_t scan, const FloorPlan& plan, Image<std::uint8_t>& seen) {
  const LaserModel& laser = world.laser;
  const SE2 world_from_laser = world.world_from_body(world.time_of(scan)) * laser.body_from_laser;
  const Vector2d origin = world_from_laser.translation();
  for (int beam = 0; beam < laser.beams; ++beam) {
    const double angle = world_from_laser.rotation().angle() + laser.first_angle + beam * laser.angle_step;
    const Vector2d direction(std::cos(angle), std::sin(angle));
    const auto hit = world.scene->trace_beside(0, {origin.x(), origin.y(), laser.height_m},
                                               {direction.x(), direction.y(), 0.0}, laser.max_range);
    const double range = hit ? hit->t + 2.0 * skin_m : laser.max_range;
    visit_cells((origin - plan.low) / plan.resolution, (origin + range * direction - plan.low) / plan.resolution,
                [&seen](int x, int y) {
                  if (x >= 0 && y >= 0 && x < seen.width() && y < seen.height()) seen.at(x, y) = 1;
                });
  }
}

Image<std::uint8_t> seen_cells(const LaserWorld& world, std::int64_t scans, const FloorPlan& plan, TaskPool& pool) {
  // A few parts, each with its own image, so that no two threads write to the same cell.
  constexpr int parts = 8;
  std::vector<Image<std::uint8_t>> seen(parts, Image<std::uint8_t>(plan.cells.width(), plan.cells.height()));
  pool.for_chunks(0, parts, 1, [&](int begin, int end) {
    for (int part = begin; part < end; ++part)
      for (std::int64_t scan = part; scan < scans; scan += parts)
        mark_seen(world, scan, plan, seen[static_cast<std::size_t>(part)]);
  });
  for (int part = 1; part < parts; ++part)
    for (int y = 0; y < plan.cells.height(); ++y)
      for (int x = 0; x < plan.cells.width(); ++x) seen[0].at(x, y) |= seen[static_cast<std::size_t>(part)].at(x, y);
  return std::move(seen[0]);
}

}  // namespace

FloorPlan true_floor_plan(const LaserWorld& world, std::int64_t scans, double resolution, TaskPool& pool) {
  const Outlines outlines = all_outlines(world);
  FloorPlan plan = empty_plan(outlines, resolution);
  const Image<std::uint8_t> seen = seen_cells(world, scans, plan, pool);
  for (int y = 0; y < seen.height(); ++y)
    for (int x = 0; x < seen.width(); ++x)
      plan.cells.at(x, y) = seen.at(x, y) != 0 ? PlanCell::free : PlanCell::unknown;
  for (const auto& outline : outlines)
    for (std::size_t i = 0; i < outline.size(); ++i)
      visit_cells((outline[i] - plan.low) / resolution, (outline[(i + 1) % outline.size()] - plan.low) / resolution,
                  [&](int x, int y) {
                    if (seen.at(x, y) != 0) plan.cells.at(x, y) = PlanCell::occupied;
                  });
  return plan;
}

void write_floor_plan(const FloorPlan& plan, const std::filesystem::path& folder) {
  std::string text =
      fmt::format("P5\n# {:g} m per cell\n{} {}\n255\n", plan.resolution, plan.cells.width(), plan.cells.height());
  for (int y = plan.cells.height() - 1; y >= 0; --y)
    for (int x = 0; x < plan.cells.width(); ++x) {
      const PlanCell cell = plan.cells.at(x, y);
      text += static_cast<char>(cell == PlanCell::occupied ? 0 : cell == PlanCell::free ? 254 : 205);
    }
  TextFile(folder / "floor_plan.pgm", text);
  TextFile(folder / "floor_plan.yaml",
           fmt::format("image: floor_plan.pgm\nresolution: {:g}\norigin: [{:g}, {:g}, 0]\nnegate: 0\n"
                       "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                       plan.resolution, plan.low.x(), plan.low.y()));
}

}  // namespace rastro
