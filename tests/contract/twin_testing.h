// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "place_testing.h"

namespace rastro {

/// Two rooms that are exactly alike, 9 m apart, with a corridor from one to the other. The robot goes once round in the
/// first, drives over and does the same in the second. A scan alone does not tell which room it is.
class TwinRooms : public TestRecording {
 public:
  static constexpr double separation_m = 9.0;

  int frame_count() const override { return 2 * round + crossing; }
  int long_count() const override { return frame_count(); }
  SourceInfo info() const override {
    SourceInfo info;
    info.path = "twin rooms";
    info.format = "generated";
    info.frame_count = frame_count();
    info.has_image = false;
    info.has_scan = info.has_odometry = true;
    return info;
  }
  TimeNs stamp(int number) const override { return 1'000 * ns_per_second + number * (ns_per_second / 10); }
  double reach_m() const override { return separation_m + 2.0; }
  SE3 world_from_body(int number) const override {
    const SE2 pose = planar_pose(number);
    return {SO3::exp(pose.rotation().angle() * Eigen::Vector3d::UnitZ()),
            {pose.translation().x(), pose.translation().y(), 0.0}};
  }
  Frame frame(int number) const override {
    Random random(seed_for(11, static_cast<std::uint64_t>(number)));
    Frame frame;
    frame.index = number;
    frame.stamp = stamp(number);
    frame.name = std::to_string(number);
    LaserScan scan;
    constexpr int beams = 271;
    scan.first_angle = -0.75 * M_PI;
    scan.angle_step = 1.5 * M_PI / (beams - 1);
    scan.min_range = 0.05;
    scan.max_range = 12.0;
    const SE2 pose = planar_pose(number);
    for (std::size_t k = 0; k < beams; ++k) {
      const double exact = range(pose.translation(), pose.rotation().angle() + scan.angle_of(k));
      scan.ranges.push_back(static_cast<float>(exact + 0.01 * random.normal()));
    }
    frame.scan = std::move(scan);
    frame.odometry_from_body = odometry(number);
    return frame;
  }

 private:
  static constexpr int round = 126, crossing = 150;  ///< Frames.

  struct Wall {
    Eigen::Vector2d from, to;
  };

  static SE2 planar_pose(int number) {
    constexpr double circle_m = 1.0;
    const auto on_circle = [](double share, double x) {
      const double angle = 2.0 * M_PI * share;
      return SE2(SO2::from_angle(angle), {x + circle_m * std::sin(angle), circle_m * (1.0 - std::cos(angle))});
    };
    if (number < round) return on_circle(static_cast<double>(number) / round, 0.0);
    if (number < round + crossing) return {SO2(), {separation_m * (number - round) / crossing, 0.0}};
    return on_circle(static_cast<double>(number - round - crossing) / round, separation_m);
  }

  /// Wheel odometry with 2 % too much translation and 1 % too little rotation.
  static SE2 odometry(int number) {
    SE2 pose;
    for (int k = 0; k < number; ++k) {
      const Eigen::Vector3d motion = (planar_pose(k).inverse() * planar_pose(k + 1)).log();
      pose = pose * SE2::exp({1.02 * motion.x(), 1.02 * motion.y(), 0.99 * motion.z()});
    }
    return pose;
  }

  static const std::vector<Wall>& walls() {
    static const std::vector<Wall> walls = [] {
      std::vector<Wall> all;
      const auto add = [&](double x0, double y0, double x1, double y1) { all.push_back({{x0, y0}, {x1, y1}}); };
      for (const double x : {0.0, separation_m}) {
        add(x - 3.0, -2.0, x + 3.0, -2.0), add(x - 3.0, 3.2, x + 3.0, 3.2);
        for (const double side : {-3.0, 3.0}) {  // with a door in the middle
          add(x + side, -2.0, x + side, -0.8), add(x + side, 0.8, x + side, 3.2);
        }
        for (const auto& [bx, by, width, depth] :
             {std::array{-2.7, 2.4, 0.9, 0.5}, {1.6, -1.9, 0.6, 0.7}, {2.2, 2.2, 0.5, 0.8}}) {
          add(x + bx, by, x + bx + width, by), add(x + bx, by + depth, x + bx + width, by + depth);
          add(x + bx, by, x + bx, by + depth), add(x + bx + width, by, x + bx + width, by + depth);
        }
      }
      for (const double x : {-6.0, 3.0, separation_m + 3.0})
        for (const double y : {-0.8, 0.8}) add(x, y, x + 3.0, y);
      add(-6.0, -0.8, -6.0, 0.8), add(separation_m + 6.0, -0.8, separation_m + 6.0, 0.8);
      return all;
    }();
    return walls;
  }

  static double range(const Eigen::Vector2d& from, double angle) {
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
    double nearest = 100.0;
    for (const Wall& wall : walls()) {
      const Eigen::Vector2d along = wall.to - wall.from, to_wall = wall.from - from;
      const double slope = cross(ray, along);
      if (std::abs(slope) < 1e-12) continue;
      const double distance = cross(to_wall, along) / slope, share = cross(to_wall, ray) / slope;
      if (distance > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, distance);
    }
    return nearest;
  }
};

/// A passage textured with one pattern, and with the same pillars, every 4 m; somebody walks along it and looks at a
/// wall, aslant. After 4 m every image is the same again, but for its noise.
class TwinPassage : public TestRecording {
 public:
  static constexpr double period_m = 4.0;

  explicit TwinPassage(const std::string& sensor) : sensor_(sensor) {}
  int frame_count() const override { return 190; }
  int long_count() const override { return frame_count(); }
  SourceInfo info() const override {
    SourceInfo info;
    info.path = "twin passage";
    info.format = "generated";
    info.frame_count = frame_count();
    info.cameras.push_back({"cam0", camera(), std::nullopt, "generated"});
    info.has_depth = sensor_ == "rgbd";
    info.has_right = sensor_ == "stereo";
    if (info.has_right) {
      info.cameras.push_back({"cam1", camera(), std::nullopt, "generated"});
      info.left_from_right = left_from_right();
    }
    return info;
  }
  TimeNs stamp(int number) const override { return 1'000 * ns_per_second + number * (ns_per_second / 20); }
  double reach_m() const override { return 10.0; }
  bool is_metric() const override { return sensor_ != "mono"; }
  SE3 world_from_body(int number) const override {
    const double distance = 0.05 * number, sway = 2.0 * M_PI * distance / period_m;
    const double yaw = 1.15 + 0.1 * std::sin(sway), pitch = 0.05 * std::sin(2.0 * sway);
    const Eigen::Vector3d ahead(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch));
    const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d axes;
    axes << right, ahead.cross(right), ahead;
    return {SO3(Eigen::Quaterniond(axes)), {distance, -1.0 + 0.1 * std::sin(sway), 1.3}};
  }
  Frame frame(int number) const override {
    Frame frame = rendered(world_from_body(number), static_cast<std::uint64_t>(number));
    if (sensor_ == "stereo")
      frame.right =
          rendered(world_from_body(number) * left_from_right(), 1000 + static_cast<std::uint64_t>(number)).image;
    if (sensor_ != "rgbd") frame.depth = {};
    frame.index = number;
    frame.stamp = frame.depth_stamp = stamp(number);
    frame.name = std::to_string(number);
    return frame;
  }

 private:
  static SE3 left_from_right() { return {SO3(), {0.12, 0.0, 0.0}}; }
  static Camera camera() {
    Camera camera;
    camera.width = 240, camera.height = 180;
    camera.fx = camera.fy = 172.0, camera.cx = 119.5, camera.cy = 89.5;
    return camera;
  }

  struct Hit {
    double distance = 0.0;
    int face = 0;
  };

  static Hit trace(const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
    Hit hit{1e9, 0};
    const auto plane = [&](int axis, double at, int face) {
      const double distance = (at - from[axis]) / along[axis];
      if (distance > 1e-9 && distance < hit.distance) hit = {distance, face};
    };
    plane(1, 1.5, 1), plane(1, -1.5, 2), plane(2, 0.0, 3), plane(2, 2.4, 4);
    for (int n = static_cast<int>(std::floor(from.x() / period_m)) - 2; n < from.x() / period_m + 3.0; ++n) {
      box({n * period_m + 0.6, 0.8, 0.0}, {n * period_m + 1.3, 1.5, 1.2}, 5, from, along, hit);
      box({n * period_m + 2.5, 1.1, 0.0}, {n * period_m + 2.9, 1.5, 2.4}, 11, from, along, hit);
    }
    return hit;
  }

  static void box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, int face, const Eigen::Vector3d& from,
                  const Eigen::Vector3d& along, Hit& hit) {
    double in = 0.0, out = 1e9;
    int entered = face;
    for (int axis = 0; axis < 3; ++axis) {
      double a = (low[axis] - from[axis]) / along[axis], b = (high[axis] - from[axis]) / along[axis];
      if (a > b) std::swap(a, b);
      if (a > in) in = a, entered = face + axis;
      out = std::min(out, b);
    }
    if (in > 1e-9 && in < out && in < hit.distance) hit = {in, entered};
  }

  /// A texture of smooth spots with cells of 5 cm, the same every period along x.
  static double shade(const Eigen::Vector3d& point, int face) {
    constexpr double cell_m = 0.05;
    const auto lattice = [&](long x, long y, long z) {
      const long cells = std::lround(period_m / cell_m);
      const auto key =
          static_cast<std::uint64_t>(((((x % cells + cells) % cells) * 997 + y + 500) * 991 + z + 500) * 31 + face);
      return Random(seed_for(5, key)).uniform();
    };
    const Eigen::Vector3d at = point / cell_m;
    const Eigen::Vector3d low = at.array().floor(), share = at - low;
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1.0;
      std::array<long, 3> cell{};
      for (int axis = 0; axis < 3; ++axis) {
        const int up = corner >> axis & 1;
        weight *= up ? share[axis] : 1.0 - share[axis];
        cell[static_cast<std::size_t>(axis)] = std::lround(low[axis]) + up;
      }
      if (weight > 1e-6) sum += weight * lattice(cell[0], cell[1], cell[2]);
    }
    return sum;
  }

  static Frame rendered(const SE3& world_from_camera, std::uint64_t noise) {
    const Camera lens = camera();
    Random random(seed_for(9, noise));
    Frame frame;
    frame.image = GrayImage(lens.width, lens.height);
    frame.depth = DepthImage(lens.width, lens.height);
    const Eigen::Matrix3d rotation = world_from_camera.rotation().matrix();
    for (int y = 0; y < lens.height; ++y) {
      for (int x = 0; x < lens.width; ++x) {
        const Eigen::Vector3d along = rotation * Eigen::Vector3d((x - lens.cx) / lens.fx, (y - lens.cy) / lens.fy, 1.0);
        const Hit hit = trace(world_from_camera.translation(), along);
        const Eigen::Vector3d point = world_from_camera.translation() + hit.distance * along;
        const double value = 40.0 + 170.0 * shade(point, hit.face) + 1.5 * random.normal();
        frame.image.at(x, y) = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
        frame.depth.at(x, y) = static_cast<float>(hit.distance);
      }
    }
    return frame;
  }

  std::string sensor_;
};

}  // namespace rastro
