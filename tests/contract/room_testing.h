// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/sensor/source.h"

namespace rastro {

/// A room with furniture, in closed form, that a robot with a laser and wheels drives through on a circle, now faster
/// and now slower. The world is where it starts.
class Room {
 public:
  static constexpr int frame_count = 90;
  /// On the mean, a frame rotates by `yaw_step_rad` on a circle of that radius.
  static constexpr double radius_m = 1.2, yaw_step_rad = 0.03;
  static constexpr TimeNs first_stamp = 1'000 * ns_per_second, step = ns_per_second / 10;

  static SourceInfo info() {
    SourceInfo info;
    info.path = "room";
    info.format = "generated";
    info.frame_count = frame_count;
    info.has_image = false;
    info.has_scan = info.has_odometry = info.has_landmarks = true;
    return info;
  }

  static TimeNs stamp(int frame) { return first_stamp + frame * step; }

  static SE2 world_from_body(int frame) {
    const double angle = yaw_step_rad * (frame + 7.0 * std::sin(frame / 9.0));
    return {SO2::from_angle(angle), radius_m * Eigen::Vector2d(std::sin(angle), 1.0 - std::cos(angle))};
  }

  /// The frames of the drive, with all data that any method needs. 210 frames are once around.
  static std::vector<Frame> frames(int count = frame_count) {
    std::vector<Frame> frames;
    for (int k = 0; k < count; ++k) frames.push_back(frame(k));
    return frames;
  }

  static Frame frame(int number) {
    Random random(seed_for(7, static_cast<std::uint64_t>(number)));
    Frame frame;
    frame.index = number;
    frame.stamp = stamp(number);
    frame.name = std::to_string(number);
    const SE2 pose = world_from_body(number);
    frame.scan = scan_from(pose, random);
    frame.landmarks = observations_from(pose, random);
    frame.odometry_from_body = odometry(number);
    return frame;
  }

  /// Distance to the nearest wall from `position` along `angle`.
  static double range(const Eigen::Vector2d& position, double angle) {
    double nearest = std::numeric_limits<double>::infinity();
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    for (const Wall& wall : walls()) {
      const Eigen::Vector2d along = wall.to - wall.from, to_wall = wall.from - position;
      const double slope = cross(ray, along);
      if (std::abs(slope) < 1e-12) continue;
      const double distance = cross(to_wall, along) / slope, share = cross(to_wall, ray) / slope;
      if (distance > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, distance);
    }
    return nearest;
  }

 private:
  struct Wall {
    Eigen::Vector2d from, to;
  };

  static double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

  static const std::vector<Eigen::Vector2d>& corners() {
    static const std::vector<Eigen::Vector2d> corners = [] {
      std::vector<Eigen::Vector2d> all;
      const auto box = [&](double x, double y, double width, double depth) {
        for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {width, 0.0}, {width, depth}, {0.0, depth}})
          all.emplace_back(x + dx, y + dy);
      };
      box(-3.7, -2.2, 7.4, 6.1);  // the room
      box(2.4, 2.3, 0.7, 0.9);    // a cupboard
      box(-2.9, -0.9, 0.8, 0.6);  // a desk
      box(-1.9, 3.1, 1.3, 0.4);   // a shelf
      return all;
    }();
    return corners;
  }

  static const std::vector<Wall>& walls() {
    static const std::vector<Wall> walls = [] {
      std::vector<Wall> all;
      const auto& corner = corners();
      for (std::size_t k = 0; k < corner.size(); ++k) all.push_back({corner[k], corner[k % 4 == 3 ? k - 3 : k + 1]});
      return all;
    }();
    return walls;
  }

  static LaserScan scan_from(const SE2& pose, Random& random) {
    constexpr int beams = 241;
    LaserScan scan;
    scan.first_angle = -2.0943951;
    scan.angle_step = -2.0 * scan.first_angle / (beams - 1);
    scan.min_range = 0.05;
    scan.max_range = 12.0;
    scan.body_from_laser = SE2(SO2(), {0.1, 0.0});
    const SE2 laser = pose * scan.body_from_laser;
    for (std::size_t k = 0; k < beams; ++k) {
      const double exact = range(laser.translation(), laser.rotation().angle() + scan.angle_of(k));
      scan.ranges.push_back(static_cast<float>(exact + 0.01 * random.normal()));
    }
    return scan;
  }

  static std::vector<LandmarkMeasurement> observations_from(const SE2& pose, Random& random) {
    std::vector<LandmarkMeasurement> seen;
    for (std::size_t k = 0; k < corners().size(); ++k) {
      const Eigen::Vector2d in_body = pose.inverse() * corners()[k];
      seen.push_back({static_cast<std::int64_t>(k), in_body.norm() * (1.0 + 0.01 * random.normal()),
                      std::atan2(in_body.y(), in_body.x()) + 0.005 * random.normal()});
    }
    return seen;
  }

  /// Wheel odometry with 2.5 % too much translation and 3 % too little rotation, in a frame of its own.
  static SE2 odometry(int frame) {
    SE2 pose(SO2::from_angle(1.0), {5.0, 3.0});
    for (int k = 0; k < frame; ++k) {
      const Eigen::Vector3d motion = (world_from_body(k).inverse() * world_from_body(k + 1)).log();
      pose = pose * SE2::exp({1.025 * motion.x(), 1.025 * motion.y(), 0.97 * motion.z()});
    }
    return pose;
  }
};

}  // namespace rastro
