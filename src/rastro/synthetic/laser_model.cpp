// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/laser_model.h"

#include <cmath>
#include <limits>

namespace rastro {
namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Distance along a ray of unit direction to a pane; infinite if it misses.
double intersect_pane(const GlassPane& pane, const Eigen::Vector2d& origin, const Eigen::Vector2d& direction) {
  const Eigen::Vector2d side = pane.to - pane.from, to_pane = pane.from - origin;
  const double determinant = cross(direction, side);
  const double range = cross(to_pane, side) / determinant, along = cross(to_pane, direction) / determinant;
  const bool met = determinant != 0.0 && range > 0.0 && along >= 0.0 && along <= 1.0;
  return met ? range : nothing;
}

/// The object that reflects the beam.
double seen_range(const LaserHit& hit, const LaserModel& model, Random& random) {
  if (!hit.glass_range) return hit.range;
  const double chance = random.uniform();
  if (hit.glass_slope > std::cos(model.glass_mirror_angle) && chance < model.glass_mirror_share)
    return *hit.glass_range;
  return chance > 1.0 - model.glass_lost_share ? nothing : hit.range;
}

float measured(double range, const LaserModel& model, Random& random) {
  const double noisy = range + model.range_sigma * random.normal();
  if (random.uniform() < model.dropout_share || noisy <= model.min_range) return 0.0F;
  const double millimeters = std::round(1000.0 * noisy);
  return static_cast<float>(std::isfinite(noisy) ? std::min(1e-3 * millimeters, model.max_range) : model.max_range);
}

}  // namespace

LaserHit trace_level(const Scene& scene, std::span<const GlassPane> panes, const Eigen::Vector2d& origin,
                     double height_m, double angle) {
  const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
  const auto solid =
      scene.trace({origin.x(), origin.y(), height_m}, Eigen::Vector3d(direction.x(), direction.y(), 0.0));
  LaserHit hit;
  hit.range = solid ? solid->t : nothing;
  double nearest = hit.range;
  for (const GlassPane& pane : panes) {
    const double range = intersect_pane(pane, origin, direction);
    if (range >= nearest) continue;
    nearest = range;
    hit.glass_range = range;
    hit.glass_slope = std::abs(cross((pane.to - pane.from).normalized(), direction));
  }
  return hit;
}

LaserScan scan_level(const Scene& scene, std::span<const GlassPane> panes, const LaserModel& model,
                     const SE2& world_from_body, Random random) {
  const SE2 world_from_laser = world_from_body * model.body_from_laser;
  LaserScan scan;
  scan.first_angle = model.first_angle, scan.angle_step = model.angle_step;
  scan.min_range = model.min_range, scan.max_range = model.max_range;
  scan.body_from_laser = model.body_from_laser;
  const double heading = world_from_laser.rotation().angle();
  for (int beam = 0; beam < model.beams; ++beam) {
    const double angle = heading + model.first_angle + beam * model.angle_step;
    const LaserHit hit = trace_level(scene, panes, world_from_laser.translation(), model.height_m, angle);
    scan.ranges.push_back(measured(seen_range(hit, model, random), model, random));
  }
  return scan;
}

}  // namespace rastro
