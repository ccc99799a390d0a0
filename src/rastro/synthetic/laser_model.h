// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>

#include "rastro/base/random.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/laser_scan.h"
#include "rastro/synthetic/scene.h"

namespace rastro {

/// Glass that reaches from the floor to above the laser, as a line in the plan. Cameras see through it.
struct GlassPane {
  Eigen::Vector2d from, to;  ///< In the world, meters.
};

/// A 2D laser scanner on a robot and its errors.
struct LaserModel {
  int beams = 541;
  double first_angle = -0.75 * std::numbers::pi;               ///< Radians, in the laser.
  double angle_step = 0.5 * std::numbers::pi / 180.0;          ///< Radians.
  double min_range = 0.05, max_range = 10.0;                   ///< Meters.
  double range_sigma = 0.01;                                   ///< Meters, normal.
  double dropout_share = 0.015;                                ///< Share of broken beams: range 0.
  double glass_mirror_angle = 8.0 * std::numbers::pi / 180.0;  ///< Within this angle of the normal, glass reflects ...
  double glass_mirror_share = 0.8;                             ///< ... this share of beams.
  double glass_lost_share = 0.15;  ///< Share of the other beams that glass deflects: max_range. The rest goes through.
  double height_m = 0.35;          ///< Above the floor.
  SE2 body_from_laser = SE2(SO2(), {0.20, 0.0});
};

/// First intersection of a level ray with each kind of object.
struct LaserHit {
  double range = 0.0;                 ///< Meters to the first solid; infinite if there is none.
  std::optional<double> glass_range;  ///< Meters to the first pane in front of it.
  double glass_slope = 1.0;           ///< Cosine between the ray and the pane's normal.
};

/// Exact, from the plan of `scene` (at its state of that moment) at the laser's height.
LaserHit trace_level(const Scene& scene, std::span<const GlassPane> panes, const Eigen::Vector2d& origin,
                     double height_m, double angle);

/// A whole scan at one moment. Ranges are rounded to millimeters, as scanners give them. All randomness comes from
/// `random`.
LaserScan scan_level(const Scene& scene, std::span<const GlassPane> panes, const LaserModel& model,
                     const SE2& world_from_body, Random random);

}  // namespace rastro
