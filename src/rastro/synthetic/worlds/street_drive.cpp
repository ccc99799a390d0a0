// SPDX-License-Identifier: Apache-2.0
#include "rastro/synthetic/worlds/street_drive.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace rastro::street {
namespace {

constexpr double turn_m = 17.0, ramp_m = 5.0;  // Length of a turn, and of the part in which the wheel steers.
constexpr double yaw_rate = 4.6, straight_speed = 9.3;
constexpr double quicken = 1.5, slow_down = 1.8;  // m/s^2
constexpr double start_before_turn_m = 3.0;
constexpr double time_step_s = 0.005, path_step_m = 0.01;

double smooth(double f) {
  f = std::clamp(f, 0.0, 1.0);
  return f * f * (3.0 - 2.0 * f);
}

/// Curvature ramps up and down smoothly; a quarter of a circle in all.
double turn_curvature(double distance) {
  if (distance <= 0.0 || distance >= turn_m) return 0.0;
  const double most = 0.5 * std::numbers::pi / (turn_m - ramp_m);
  return most * smooth(distance / ramp_m) * smooth((turn_m - distance) / ramp_m);
}

double wrapped(double value, double length) { return value - length * std::floor(value / length); }

double wave(double seconds, double period_s, double phase) {
  return std::sin(2.0 * std::numbers::pi * seconds / period_s + phase);
}

}  // namespace

Drive::Drive() {
  PlanPose pose;
  turn_.push_back(pose);
  for (int step = 0; step < static_cast<int>(turn_m / path_step_m); ++step) {
    const double half = 0.5 * path_step_m * turn_curvature((step + 0.5) * path_step_m);
    pose.x += path_step_m * std::cos(pose.heading + half);
    pose.y += path_step_m * std::sin(pose.heading + half);
    pose.heading += 2.0 * half;
    turn_.push_back(pose);
  }
  turn_reach_ = pose.x;
  // The lane is half its width outside the center lines.
  straight_m_[0] = block_y + lane - 2.0 * turn_reach_;
  straight_m_[1] = block_x + lane - 2.0 * turn_reach_;
  lap_m_ = 4.0 * turn_m + 2.0 * (straight_m_[0] + straight_m_[1]);
  for (double distance = 0.0; distance < lap_m_; distance += time_step_s * wanted_speed(distance))
    distances_.push_back(distance);
  lap_s_ = static_cast<double>(distances_.size()) * time_step_s;
}

double Drive::wanted_speed(double distance) const {
  double from_start = wrapped(distance - start_before_turn_m, lap_m_);
  int side = 0;
  while (from_start >= turn_m + straight_m_[side % 2]) from_start -= turn_m + straight_m_[side++ % 2];
  if (from_start < turn_m) return yaw_rate;
  const double gone = from_start - turn_m, left = straight_m_[side % 2] - gone;
  const double slowest = yaw_rate * yaw_rate;
  const double most = straight_speed + 0.35 * std::sin(0.05 * distance);
  return std::min({most, std::sqrt(slowest + 2.0 * quicken * gone), std::sqrt(slowest + 2.0 * slow_down * left)});
}

double Drive::path_at(double time_s) const {
  const double laps = std::floor(time_s / lap_s_);
  const double position = (time_s - laps * lap_s_) / time_step_s;
  const std::size_t index = std::min(distances_.size() - 1, static_cast<std::size_t>(position));
  const double here = distances_[index], next = index + 1 < distances_.size() ? distances_[index + 1] : lap_m_;
  return laps * lap_m_ + here + (position - static_cast<double>(index)) * (next - here);
}

double Drive::speed_at(double time_s) const { return (path_at(time_s + 0.1) - path_at(time_s - 0.1)) / 0.2; }

double Drive::curvature_at_distance(double distance) const {
  double from_start = wrapped(distance - start_before_turn_m, lap_m_);
  for (int side = 0; from_start >= turn_m + straight_m_[side % 2]; ++side) from_start -= turn_m + straight_m_[side % 2];
  return turn_curvature(from_start);
}

PlanPose Drive::pose_at_distance(double distance) const {
  double from_start = wrapped(distance - start_before_turn_m, lap_m_);
  // Begin of the first turn: on the lane beside y = 0, before the corner at x = block_x.
  PlanPose pose{block_x + 0.5 * lane - turn_reach_, -0.5 * lane, 0.0};
  const auto go = [&pose](const PlanPose& step) {
    const double c = std::cos(pose.heading), s = std::sin(pose.heading);
    pose = {pose.x + c * step.x - s * step.y, pose.y + s * step.x + c * step.y, pose.heading + step.heading};
  };
  for (int side = 0;; ++side) {
    if (from_start < turn_m) break;
    go(turn_.back());
    from_start -= turn_m;
    const double straight = std::min(from_start, straight_m_[side % 2]);
    go({straight, 0.0, 0.0});
    if (from_start < straight_m_[side % 2]) return pose;
    from_start -= straight;
  }
  const double position = from_start / path_step_m;
  const std::size_t index = std::min(turn_.size() - 2, static_cast<std::size_t>(position));
  const double f = position - static_cast<double>(index);
  const PlanPose &a = turn_[index], &b = turn_[index + 1];
  go({a.x + f * (b.x - a.x), a.y + f * (b.y - a.y), a.heading + f * (b.heading - a.heading)});
  return pose;
}

CameraPath drive_path() {
  const auto drive = std::make_shared<const Drive>();
  const auto control = [drive](std::int64_t index) {
    const double time = static_cast<double>(index) / rate_hz;
    const double distance = drive->path_at(time), speed = drive->speed_at(time);
    const PlanPose plan = drive->pose_at_distance(distance);
    const double quickening = (drive->speed_at(time + 0.3) - drive->speed_at(time - 0.3)) / 0.6;
    const double sideways = speed * speed * drive->curvature_at_distance(distance);
    // The nose dips under braking, and the car leans out of the turn; the rest is the road's unevenness.
    const double pitch = -0.0045 * quickening + 0.0030 * wave(time, 1.31, 0.4) + 0.0016 * wave(time, 0.57, 2.0);
    const double roll = 0.0080 * sideways + 0.0035 * wave(time, 1.73, 1.1) + 0.0015 * wave(time, 0.71, 0.3);
    const double yaw = plan.heading + 0.0020 * wave(time, 3.7, 0.8);
    const double aside = 0.06 * wave(time, 5.9, 0.2);
    const double height = camera_height_m + 0.010 * wave(time, 1.19, 0.9) + 0.005 * wave(time, 0.49, 2.2);
    return SE3(looking(yaw, pitch, roll),
               {plan.x - aside * std::sin(plan.heading), plan.y + aside * std::cos(plan.heading), height});
  };
  return {control, 1.0 / rate_hz};
}

}  // namespace rastro::street
