// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/campus_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "rastro/synthetic/worlds/campus_plan.h"

namespace rastro::campus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180.0;
constexpr double knots_hz = 10.0, grid_m = 0.1;
constexpr double cruise = 1.1, stairs_speed = 0.65, yaw_rate = 0.5, quicken = 0.4;  // m/s, rad/s, m/s^2
constexpr std::array<double, laps> slowness = {1.04, 1.07, 1.048};

struct Corner {
  double x, y, z, radius;  ///< The radius is 0 where the direction stays.
};

constexpr double stairs_down_end = stairs_down_x + stairs_m, stairs_up_end = stairs_up_x + stairs_m;
constexpr double landing_x = stairs_up_end + 1.6, up = storey_m, indoors = 1.1, outdoors = 3.0;
// Along the parking lot to the entrance in the south; three corridors and the courtyard; up the stairs, three corridors
// of the upper floor, down the other stairs, and outside back to the parking lot.
constexpr Corner corners[] = {
    {50, -32, 0, 0},
    {14, -32, 0, outdoors},
    {14, -16, 0, outdoors},
    {30, -16, 0, outdoors},
    {30, 0, 0, indoors},
    {0, 0, 0, indoors},
    {0, ring_y, 0, indoors},
    {30, ring_y, 0, indoors},
    {30, 24, 0, outdoors},
    {14, 24, 0, outdoors},
    {14, 12, 0, outdoors},
    {ring_x, 12, 0, indoors},
    {ring_x, 0, 0, indoors},
    {stairs_up_x - 0.3, 0, 0, 0},
    {stairs_up_end - 0.1, 0, up, 0},
    {landing_x, 0, up, indoors},
    {landing_x, 3, up, indoors},
    {ring_x, 3, up, indoors},
    {ring_x, 0, up, indoors},
    {0, 0, up, indoors},
    {0, ring_y, up, indoors},
    {stairs_down_x - 0.1, ring_y, up, 0},
    {stairs_down_end + 0.3, ring_y, 0, 0},
    {82, ring_y, 0, outdoors},
    {82, -32, 0, outdoors},
};

double wave(double seconds, double period_s, double phase) {
  return std::sin(2.0 * std::numbers::pi * seconds / period_s + phase);
}

/// The walker keeps a little to one side, another one in each lap.
double aside_m(double distance) {
  const double lap_m = tour().lap_m();
  const int lap = std::clamp(static_cast<int>(distance / lap_m), 0, laps - 1);
  constexpr double side[laps] = {0.0, 0.14, -0.14};
  // Changes over the first meters of a lap.
  const double from = side[std::max(0, lap - 1)];
  const double share = std::clamp((distance - lap * lap_m) / 12.0, 0.0, 1.0);
  return from + (side[lap] - from) * share + 0.08 * std::sin(distance / 9.7);
}

SE3 control(std::int64_t index) {
  const double seconds = static_cast<double>(index) / knots_hz, distance = tour().distance_at(seconds);
  const TourPoint here = tour().point(distance);
  const double slope = (tour().point(distance + 0.8).position.z() - tour().point(distance - 0.8).position.z()) / 1.6;
  const double height = 0.5 * (tour().point(distance + 0.25).position.z() + tour().point(distance - 0.25).position.z());
  const double aside = aside_m(distance);
  const Vector3d sway(0.010 * wave(seconds, 1.07, 0.3), 0.012 * wave(seconds, 1.31, 2.0),
                      0.016 * wave(seconds, 0.57, 0.7));
  const double yaw = here.heading + degree * (2.5 * wave(seconds, 23.0, 0.4) + 1.2 * wave(seconds, 3.1, 0.2) +
                                              0.6 * wave(seconds, 1.13, 1.9));
  // Looks where it goes: upwards on stairs that lead up.
  const double pitch =
      -0.45 * std::atan(slope) + degree * (2.0 + 0.7 * wave(seconds, 2.3, 1.2) + 0.5 * wave(seconds, 0.57, 0.6));
  const double roll = degree * (0.6 * wave(seconds, 1.13, 2.8) + 0.3 * wave(seconds, 5.3, 0.9));
  const Vector3d left(-std::sin(here.heading), std::cos(here.heading), 0.0);
  return {looking(yaw, pitch, roll),
          Vector3d(here.position.x(), here.position.y(), height + camera_height_m) + aside * left + sway};
}

}  // namespace

double Tour::Piece::length() const { return straight + std::abs(turn) * radius; }

Tour::Tour() {
  make_pieces();
  make_times();
}

void Tour::make_pieces() {
  constexpr std::size_t count = std::size(corners);
  const auto plan = [](std::size_t i) { return Vector2d(corners[i % count].x, corners[i % count].y); };
  const Vector2d first = plan(1) - plan(0);
  double heading = std::atan2(first.y(), first.x()), cut_before = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d leg = plan(i + 1) - plan(i), next = plan(i + 2) - plan(i + 1);
    Piece piece;
    piece.along = leg.normalized();
    const double z = corners[i].z, z_end = corners[(i + 1) % count].z;
    piece.slope = (z_end - z) / leg.norm();
    piece.heading = heading;
    piece.turn = std::atan2(leg.x() * next.y() - leg.y() * next.x(), leg.dot(next));
    piece.radius = corners[(i + 1) % count].radius;
    const double cut = piece.radius * std::tan(0.5 * std::abs(piece.turn));
    const Vector2d from = plan(i) + cut_before * piece.along;
    piece.from = {from.x(), from.y(), z};
    piece.straight = leg.norm() - cut_before - cut;
    cut_before = cut;
    heading += piece.turn;
    lap_m_ += piece.length();
    pieces_.push_back(piece);
  }
}

TourPoint Tour::point(double distance) const {
  const double lap = std::floor(distance / lap_m_);
  distance -= lap * lap_m_;
  std::size_t number = 0;
  for (; number + 1 < pieces_.size() && distance >= pieces_[number].length(); ++number)
    distance -= pieces_[number].length();
  const Piece& piece = pieces_[number];
  const double straight = std::min(distance, piece.straight);
  TourPoint result;
  const Vector2d ahead = straight * piece.along;
  result.position = piece.from + Vector3d(ahead.x(), ahead.y(), straight * piece.slope);
  result.heading = piece.heading;
  result.slope = distance < piece.straight ? piece.slope : 0.0;
  if (distance <= piece.straight || piece.turn == 0.0) return result;
  const double side = piece.turn > 0.0 ? 1.0 : -1.0, angle = (distance - piece.straight) / piece.radius;
  const Vector2d left = side * Vector2d(-piece.along.y(), piece.along.x());
  const Vector2d curve = piece.radius * (std::sin(angle) * piece.along + (1.0 - std::cos(angle)) * left);
  result.position += Vector3d(curve.x(), curve.y(), 0.0);
  result.heading += side * angle;
  return result;
}

void Tour::make_times() {
  const auto count = static_cast<std::size_t>(lap_m_ / grid_m);
  std::vector<double> speed(count, cruise);
  for (std::size_t i = 0; i < count; ++i) {
    const double distance = (static_cast<double>(i) + 0.5) * grid_m;
    const TourPoint here = point(distance), next = point(distance + 0.02);
    const double curvature = std::abs(next.heading - here.heading) / 0.02;
    // The lap ends with another heading than it began with: a whole number of rotations.
    if (curvature > 1e-6 && curvature < 10.0) speed[i] = std::min(cruise, yaw_rate / curvature);
    if (here.slope != 0.0) speed[i] = stairs_speed;
  }
  const auto limit = [&](std::size_t i, std::size_t from) {
    speed[i] = std::min(speed[i], std::sqrt(speed[from] * speed[from] + 2.0 * quicken * grid_m));
  };
  for (std::size_t i = 1; i < 2 * count; ++i) limit(i % count, (i - 1) % count);
  for (std::size_t i = 2 * count - 1; i > 0; --i) limit((i - 1) % count, i % count);
  seconds_.push_back(0.0);
  for (const double value : speed) seconds_.push_back(seconds_.back() + lap_m_ / static_cast<double>(count) / value);
  for (std::size_t lap = 0; lap < laps; ++lap)
    lap_begin_s_[lap + 1] = lap_begin_s_[lap] + slowness[lap] * seconds_.back();
}

double Tour::distance_at(double time_s) const {
  if (time_s >= end_s()) return laps * lap_m_;
  std::size_t lap = 0;
  while (time_s >= lap_begin_s_[lap + 1]) ++lap;
  const double seconds = (time_s - lap_begin_s_[lap]) / slowness[lap];
  if (seconds <= 0.0) return static_cast<double>(lap) * lap_m_;
  const auto after =
      static_cast<std::size_t>(std::upper_bound(seconds_.begin(), seconds_.end() - 1, seconds) - seconds_.begin());
  const double share = (seconds - seconds_[after - 1]) / (seconds_[after] - seconds_[after - 1]);
  const double step = lap_m_ / static_cast<double>(seconds_.size() - 1);
  return static_cast<double>(lap) * lap_m_ + (static_cast<double>(after - 1) + share) * step;
}

double Tour::nearest(const Vector3d& position) const {
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (double distance = 0.0; distance < lap_m_; distance += 0.5) {
    Vector3d offset = point(distance).position - position;
    offset.z() *= 4.0;  // Floors are far apart.
    if (offset.squaredNorm() >= least) continue;
    least = offset.squaredNorm();
    best = distance;
  }
  return best;
}

int Tour::visit(double time_s, double at_m) const {
  return std::clamp(static_cast<int>(std::floor((distance_at(time_s) - at_m) / lap_m_ + 0.5)), 0, laps - 1);
}

const Tour& tour() {
  static const Tour result;
  return result;
}

CameraPath walk_path() { return {control, 1.0 / knots_hz}; }

}  // namespace rastro::campus
