// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/loop_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include "rastro/synthetic/worlds/loop.h"
#include "rastro/synthetic/worlds/loop_scene.h"

namespace rastro::loop {
namespace {

using Eigen::Vector2d;

constexpr double degree = std::numbers::pi / 180.0;
constexpr double knots_hz = 10.0;
constexpr double radius_m = 2.2;  // Of the turns; all are right angles.

// Around the big house, along the first street again, around the small one and over the square.
const std::array<Vector2d, 10> corners = {Vector2d(2.0, 0.0),  {22.0, 0.0},  {22.0, 14.0}, {0.0, 14.0},  {0.0, 0.0},
                                          Vector2d(12.0, 0.0), {12.0, -9.0}, {0.0, -9.0},  {0.0, 14.62}, {0.0, 14.62}};
constexpr std::size_t legs = 8;

struct Leg {
  Vector2d from, along;
  double straight = 0.0;  // Without the turns at its ends.
  double heading = 0.0;
  double turn = 0.0;  // At its end: +1 to the left, -1 to the right, 0 none.
};

std::array<Leg, legs> make_legs() {
  std::array<Leg, legs> result;
  double heading = 0.0;
  for (std::size_t i = 0; i < legs; ++i) {
    Leg& leg = result[i];
    const Vector2d whole = corners[i + 1] - corners[i];
    leg.along = whole.normalized();
    leg.heading = heading;
    const double begin = i == 0 ? 0.0 : result[i - 1].turn != 0.0 ? radius_m : 0.0;
    if (i + 1 < legs) {
      const Vector2d next = (corners[i + 2] - corners[i + 1]).normalized();
      leg.turn = std::round(leg.along.x() * next.y() - leg.along.y() * next.x());
    }
    leg.from = corners[i] + begin * leg.along;
    leg.straight = whole.norm() - begin - (leg.turn != 0.0 ? radius_m : 0.0);
    heading += leg.turn * 0.5 * std::numbers::pi;
  }
  return result;
}

const std::array<Leg, legs>& path_legs() {
  static const std::array<Leg, legs> result = make_legs();
  return result;
}

double length(const Leg& leg) { return leg.straight + std::abs(leg.turn) * 0.5 * std::numbers::pi * radius_m; }

PathPoint on_leg(const Leg& leg, double distance) {
  if (distance <= leg.straight) return {leg.from + distance * leg.along, leg.heading};
  const double angle = (distance - leg.straight) / radius_m;
  const Vector2d left = leg.turn * Vector2d(-leg.along.y(), leg.along.x());
  return {
      leg.from + (leg.straight + radius_m * std::sin(angle)) * leg.along + radius_m * (1.0 - std::cos(angle)) * left,
      leg.heading + leg.turn * angle};
}

/// Yaw of the head (degrees to the left of the path) at a point of the path.
struct Glance {
  double distance, degrees;
};
constexpr Glance glances[] = {{0, 15},    {6, 15},  {13, 0}, {54.5, 0}, {58.5, -80}, {62, -80}, {65.5, 0},
                              {68.0, 15}, {75, 15}, {78, 0}, {107, 0},  {111.5, 80}, {120, 80}};

double smooth(double f) { return f * f * (3.0 - 2.0 * f); }

double glance(double distance) {
  const Glance* next =
      std::find_if(std::begin(glances), std::end(glances), [&](const Glance& g) { return g.distance > distance; });
  if (next == std::begin(glances)) return glances[0].degrees;
  if (next == std::end(glances)) return std::prev(next)->degrees;
  const Glance& before = *std::prev(next);
  return before.degrees +
         smooth((distance - before.distance) / (next->distance - before.distance)) * (next->degrees - before.degrees);
}

double wave(double seconds, double period_s, double phase) {
  return std::sin(2.0 * std::numbers::pi * seconds / period_s + phase);
}

/// Steps, and a hand that is never still.
SE3 in_hand(const Eigen::Vector3d& position, double yaw, double seconds) {
  const Eigen::Vector3d sway(0.012 * wave(seconds, 1.07, 0.3), 0.014 * wave(seconds, 1.31, 2.0),
                             0.014 * wave(seconds, 0.53, 0.7));
  const double yaw_offset = 0.7 * wave(seconds, 1.9, 0.2) + 0.3 * wave(seconds, 0.61, 1.9);
  const double pitch = 1.0 + 0.7 * wave(seconds, 1.43, 1.2) + 0.3 * wave(seconds, 0.53, 0.6);
  const double roll = 0.7 * wave(seconds, 1.07, 2.8) + 0.3 * wave(seconds, 0.47, 0.9);
  return {looking(yaw + yaw_offset * degree, pitch * degree, roll * degree), position + sway};
}

SE3 walked(std::int64_t index) {
  const double seconds = static_cast<double>(index) / knots_hz, distance = speed * seconds;
  const PathPoint point = path_point(distance);
  return in_hand({point.position.x(), point.position.y(), camera_height_m}, point.heading + glance(distance) * degree,
                 seconds);
}

SE3 elsewhere(std::int64_t index) {
  const double seconds = static_cast<double>(index) / knots_hz;
  const double gone = seconds - static_cast<double>(loop_elsewhere_begin) / rate_hz;
  return in_hand(elsewhere_position + Eigen::Vector3d(0.3 * gone, 0.5 * gone, 0.0), -0.12 * gone, seconds);
}

}  // namespace

double path_m() {
  double total = 0.0;
  for (const Leg& leg : path_legs()) total += length(leg);
  return total;
}

double round_m() {
  double total = corners[0].x() - radius_m;
  for (std::size_t i = 0; i < 4; ++i) total += length(path_legs()[i]);
  return total;
}

PathPoint path_point(double distance) {
  distance = std::max(0.0, distance);
  for (const Leg& leg : path_legs()) {
    if (distance < length(leg)) return on_leg(leg, distance);
    distance -= length(leg);
  }
  return on_leg(path_legs().back(), length(path_legs().back()));
}

CameraPath walk_path() {
  constexpr double cut = (static_cast<double>(loop_elsewhere_begin) - 0.5) / rate_hz;
  constexpr double back = (static_cast<double>(loop_elsewhere_end) - 0.5) / rate_hz;
  const CameraPath walk(walked, 1.0 / knots_hz), other(elsewhere, 1.0 / knots_hz);
  return CameraPath([walk, other](double time_s) {
    if (time_s >= cut && time_s < back) return other.world_from_camera(time_s);
    return walk.world_from_camera(time_s < cut ? time_s : time_s - (back - cut));
  });
}

}  // namespace rastro::loop
