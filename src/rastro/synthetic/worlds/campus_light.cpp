// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/campus_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "rastro/base/random.h"
#include "rastro/synthetic/worlds/campus_plan.h"
#include "rastro/synthetic/worlds/campus_walk.h"

namespace rastro::campus {
namespace {

using Eigen::Vector3d;

// Of the three laps.
constexpr std::array<double, laps> sun_strength = {0.95, 0.12, 0.75}, sky_strength = {0.75, 1.0, 0.6};
constexpr std::array<double, laps> daylight_inside = {0.30, 0.24, 0.12}, lamps_lit = {0.85, 0.95, 0.6};
constexpr double outside_level = 1.5;  ///< Of the light outside, in that of the lamps inside.
constexpr double change_s = 40.0;      ///< The light changes before the end of a lap within this time.
constexpr double lamp_pitch_m = 3.0;

/// Shares of the three lights at a time.
std::array<double, laps> shares_at(double time_s) {
  std::array<double, laps> shares{};
  double left = 1.0;
  for (int lap = laps - 1; lap > 0; --lap) {
    const double come = std::clamp((time_s - tour().lap_begin_s(lap)) / change_s + 1.0, 0.0, 1.0);
    shares[static_cast<std::size_t>(lap)] = left * come;
    left *= 1.0 - come;
  }
  shares[0] = left;
  return shares;
}

double mixed(const std::array<double, laps>& values, const std::array<double, laps>& shares) {
  double sum = 0.0;
  for (std::size_t lap = 0; lap < laps; ++lap) sum += shares[lap] * values[lap];
  return sum;
}

/// From the east in the morning to the west in the evening.
Vector3d sun_at(double time_s) {
  const double day = std::clamp(time_s / tour().end_s(), 0.0, 1.0);
  const double azimuth = -0.15 * std::numbers::pi - 0.72 * std::numbers::pi * day;
  const double height = 0.35 + 0.45 * std::sin(std::numbers::pi * day);
  return {std::cos(azimuth) * std::cos(height), std::sin(azimuth) * std::cos(height), std::sin(height)};
}

struct Block {
  Vector3d low, high;
};
// The four wings, slightly smaller than their facades, which must not shade themselves.
const Block wings[] = {
    {{outer_west + 0.1, outer_south + 0.1, -1}, {outer_east - 0.1, court_south - 0.1, roof_m}},
    {{outer_west + 0.1, court_north + 0.1, -1}, {outer_east - 0.1, outer_north - 0.1, roof_m}},
    {{outer_west + 0.1, court_south - 0.1, -1}, {court_west - 0.1, court_north + 0.1, roof_m}},
    {{court_east + 0.1, court_south - 0.1, -1}, {outer_east - 0.1, court_north + 0.1, roof_m}},
};

bool in_wing(const Vector3d& point) {
  return point.z() < roof_m - 0.05 && std::any_of(std::begin(wings), std::end(wings), [&](const Block& wing) {
           return (point.array() > wing.low.array()).all() && (point.array() < wing.high.array()).all();
         });
}

bool is_shaded(const Vector3d& point, const Vector3d& sun) {
  for (const Block& wing : wings) {
    double enter = 0.0, leave = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (wing.low[axis] - point[axis]) / sun[axis], b = (wing.high[axis] - point[axis]) / sun[axis];
      enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
    }
    if (enter < leave) return true;
  }
  return false;
}

/// Light of the lamps along the corridors: per lap, floor and corridor a table over the place.
class Lamps {
 public:
  explicit Lamps(std::uint64_t seed) {
    Random random(seed_for(seed, 61));
    for (std::size_t lap = 0; lap < laps; ++lap)
      for (auto& table : tables_[lap]) fill(table, random, lamps_lit[lap]);
  }
  double at(std::size_t lap, std::size_t corridor, double place_m) const {
    const double cell = std::clamp((place_m + margin_m) / cell_m, 0.0, cells - 1.001);
    const auto index = static_cast<std::size_t>(cell);
    const auto& table = tables_[lap][corridor];
    return table[index] + (cell - static_cast<double>(index)) * (table[index + 1] - table[index]);
  }

 private:
  static constexpr std::size_t cells = 180;
  static constexpr double cell_m = 0.5, margin_m = 6.0;
  using Table = std::array<double, cells>;

  static void fill(Table& table, Random& random, double lit) {
    for (double lamp = -margin_m; lamp < cells * cell_m; lamp += lamp_pitch_m) {
      const double strength = random.uniform() < lit ? random.uniform(0.8, 1.1) : 0.08;
      for (std::size_t i = 0; i < cells; ++i) {
        const double off = (static_cast<double>(i) * cell_m - margin_m - lamp) / 1.9;
        table[i] += 0.58 * strength * std::exp(-0.5 * off * off);
      }
    }
  }
  std::array<std::array<Table, 8>, laps> tables_{};
};

class Light {
 public:
  explicit Light(std::uint64_t seed) : lamps_(seed) {
    Random random(seed_for(seed, 62));
    for (double& strength : sun_strength_) strength = random.uniform(0.85, 1.15);
  }
  float at(const Vector3d& point, const Vector3d& normal, double time_s) const {
    const auto shares = shares_at(time_s);
    return static_cast<float>(in_wing(point) ? inside(point, shares) : outside(point, normal, time_s, shares));
  }

 private:
  double inside(const Vector3d& point, const std::array<double, laps>& shares) const {
    const std::size_t upper = point.z() > 0.5 * (ceiling_m + storey_m) ? 1 : 0;
    const bool in_south = point.y()<half_corridor + 0.2, in_north = point.y()> ring_y - half_corridor - 0.2;
    const bool in_west = point.x() < 0.5 * ring_x;
    const std::size_t corridor = 4 * upper + (in_south ? 0 : in_north ? 1 : in_west ? 2 : 3);
    const double place = in_south || in_north ? point.x() : point.y();
    double light = mixed(daylight_inside, shares);
    if (!in_south && !in_north) light *= 1.6;  // The windows to the courtyard.
    for (std::size_t lap = 0; lap < laps; ++lap)
      if (shares[lap] > 0.0) light += shares[lap] * lamps_.at(lap, corridor, place);
    return light;
  }

  double outside(const Vector3d& point, const Vector3d& normal, double time_s,
                 const std::array<double, laps>& shares) const {
    const double sky = mixed(sky_strength, shares);
    if (point.z() > 25.0 || std::abs(point.x() - 35.0) > 120.0 || std::abs(point.y() - 5.0) > 120.0)
      return outside_level * sky;  // The sky itself.
    const Vector3d sun = sun_at(time_s);
    const double facing = normal.dot(sun);
    double light = 0.72 * sky;
    if (facing > 0.0 && !is_shaded(point + 0.15 * normal, sun))
      light += facing * mixed(sun_strength, shares) * mixed(sun_strength_, shares);
    return outside_level * light;
  }

  Lamps lamps_;
  std::array<double, laps> sun_strength_{};
};

/// How much of what the camera sees is outside, 0 to 1, at a time.
double outside_share(double time_s) {
  double sum = 0.0;
  constexpr int probes = 5;
  for (int probe = 0; probe < probes; ++probe) {
    // Ahead of the camera: what it sees.
    const Vector3d ahead = tour().point(tour().distance_at(time_s) + 1.0 * probe).position;
    sum += in_wing(ahead + Vector3d(0, 0, 1.0)) ? 0.0 : 1.0;
  }
  return sum / probes;
}

}  // namespace

LightField make_light(std::uint64_t seed) {
  const auto light = std::make_shared<const Light>(seed);
  return [light](const Vector3d& point, const Vector3d& normal, double time_s) {
    return light->at(point, normal, time_s);
  };
}

SensorModel sensor_at(double time_s) {
  constexpr std::array<double, laps> inside_gain = {1.12, 1.05, 1.45}, outside_gain = {0.72, 0.86, 0.80};
  double outside = 0.0;
  constexpr int delays = 8;
  for (int i = 0; i < delays; ++i) outside += outside_share(time_s - 0.3 * i) / delays;
  const auto shares = shares_at(time_s);
  const double drift = 1.0 + 0.06 * std::sin(2.0 * std::numbers::pi * time_s / 13.0);
  SensorModel sensor;
  sensor.exposure_time_s = 0.005;
  sensor.vignette = 0.15F;
  sensor.gain = static_cast<float>(drift * std::pow(mixed(outside_gain, shares), outside) *
                                   std::pow(mixed(inside_gain, shares), 1.0 - outside));
  return sensor;
}

}  // namespace rastro::campus
