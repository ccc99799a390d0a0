// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/corridor_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rastro::corridor {
namespace {

constexpr double turn_m = 1.2, ramp_m = 0.4;  // Length of a turn, and of the part in which the wheels steer.
constexpr double quicken = 0.3;               // m/s^2, and the same for braking.
constexpr double turn_step_m = 0.001, path_step_m = 0.01;

// Corners of the path; all turns are right angles.
const std::vector<Eigen::Vector2d>& corners() {
  static const std::vector<Eigen::Vector2d> list = {{0, 0},  {12.5, 0}, {12.5, -3}, {17.5, -3}, {17.5, 0},
                                                    {20, 0}, {20, 8},   {-8, 8},    {-8, 0},    {overlap_m, 0}};
  return list;
}

double smooth(double f) {
  f = std::clamp(f, 0.0, 1.0);
  return f * f * (3.0 - 2.0 * f);
}

/// Curvature ramps up and down smoothly; a quarter of a circle in all.
double turn_curvature(double distance) {
  const double most = 0.5 * std::numbers::pi / (turn_m - ramp_m);
  return most * smooth(distance / ramp_m) * smooth((turn_m - distance) / ramp_m);
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

Drive::Drive() {
  make_turn();
  make_legs();
  make_arrivals();
}

void Drive::make_turn() {
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  turn_.push_back(pose);
  const int steps = static_cast<int>(std::lround(turn_m / turn_step_m));
  for (int step = 0; step < steps; ++step) {
    const double half = 0.5 * turn_step_m * turn_curvature((step + 0.5) * turn_step_m);
    pose += Eigen::Vector3d(turn_step_m * std::cos(pose.z() + half), turn_step_m * std::sin(pose.z() + half), 2 * half);
    turn_.push_back(pose);
  }
  turn_reach_ = pose.x();
}

void Drive::make_legs() {
  const auto& path = corners();
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Eigen::Vector2d along = (path[i + 1] - path[i]).normalized();
    const bool first = i == 0, last = i + 2 == path.size();
    Leg leg;
    leg.begin_m = length_m_;
    leg.world_from_begin =
        SE2(SO2::from_angle(std::atan2(along.y(), along.x())), path[i] + (first ? 0.0 : turn_reach_) * along);
    leg.straight_m = (path[i + 1] - path[i]).norm() - (first ? 0.0 : turn_reach_) - (last ? 0.0 : turn_reach_);
    if (!last) leg.turn = cross(along, path[i + 2] - path[i + 1]) > 0.0 ? 1 : -1;
    length_m_ += leg.straight_m + (last ? 0.0 : turn_m);
    legs_.push_back(leg);
  }
}

void Drive::make_arrivals() {
  const int steps = static_cast<int>(std::ceil(length_m_ / path_step_m));
  const double step_m = length_m_ / steps;
  std::vector<double> speed(static_cast<std::size_t>(steps) + 1, most_speed);
  for (std::size_t i = 0; i < speed.size(); ++i)
    for (const Leg& leg : legs_) {
      const double into_turn_m = static_cast<double>(i) * step_m - leg.begin_m - leg.straight_m;
      if (leg.turn != 0 && into_turn_m >= 0.0 && into_turn_m <= turn_m) speed[i] = yaw_rate;
    }
  speed.front() = speed.back() = 0.0;
  const auto limit = [step_m](double& here, double beside) {
    here = std::min(here, std::sqrt(beside * beside + 2.0 * quicken * step_m));
  };
  for (std::size_t i = 1; i < speed.size(); ++i) limit(speed[i], speed[i - 1]);
  for (std::size_t i = speed.size() - 1; i > 0; --i) limit(speed[i - 1], speed[i]);
  arrivals_.push_back(0.0);
  for (std::size_t i = 1; i < speed.size(); ++i)
    arrivals_.push_back(arrivals_.back() + 2.0 * step_m / (speed[i - 1] + speed[i]));
}

double Drive::path_at(double time_s) const {
  if (time_s <= 0.0) return 0.0;
  if (time_s >= arrivals_.back()) return length_m_;
  const auto next = std::upper_bound(arrivals_.begin(), arrivals_.end(), time_s);
  const auto index = static_cast<std::size_t>(next - arrivals_.begin());
  const double before = arrivals_[index - 1], share = (time_s - before) / (arrivals_[index] - before);
  return (static_cast<double>(index - 1) + share) * length_m_ / static_cast<double>(arrivals_.size() - 1);
}

double Drive::loop_end_s() const {
  const double position = (length_m_ - overlap_m) / length_m_ * static_cast<double>(arrivals_.size() - 1);
  const auto index = static_cast<std::size_t>(position);
  return arrivals_[index] + (position - static_cast<double>(index)) * (arrivals_[index + 1] - arrivals_[index]);
}

SE2 Drive::in_turn(double path_m, int side) const {
  const double position = std::clamp(path_m, 0.0, turn_m) / turn_step_m;
  const std::size_t index = std::min(turn_.size() - 2, static_cast<std::size_t>(position));
  const Eigen::Vector3d pose =
      turn_[index] + (position - static_cast<double>(index)) * (turn_[index + 1] - turn_[index]);
  return {SO2::from_angle(side * pose.z()), {pose.x(), side * pose.y()}};
}

SE2 Drive::pose_at_distance(double path_m) const {
  const double distance = std::clamp(path_m, 0.0, length_m_);
  std::size_t number = 0;
  while (number + 1 < legs_.size() && legs_[number + 1].begin_m <= distance) ++number;
  const Leg& leg = legs_[number];
  const double gone = distance - leg.begin_m;
  const SE2 straight(SO2(), {std::min(gone, leg.straight_m), 0.0});
  if (gone <= leg.straight_m) return leg.world_from_begin * straight;
  return leg.world_from_begin * straight * in_turn(gone - leg.straight_m, leg.turn);
}

}  // namespace rastro::corridor
