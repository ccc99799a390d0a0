// SPDX-License-Identifier: Apache-2.0
// A drive through a room in closed form, and the error of an odometry on it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "rastro/sensor/source.h"

namespace rastro {

/// One camera, with exact depth, that drives at constant speed around a bend to the right. Frames are made once.
class DriveWorld {
 public:
  static constexpr int frame_count = 40;
  static constexpr double step_m = 0.025, bend_deg = 1.5;  ///< A frame goes so far and rotates by so much in the bend.
  static constexpr int straight = 8;                       ///< Frames before the bend.

  static SourceInfo info() {
    SourceInfo info;
    info.path = "drive";
    info.format = "generated";
    info.frame_count = frame_count;
    info.has_depth = true;
    info.cameras.push_back({"rgb", camera(), std::nullopt, "generated"});
    return info;
  }

  static Frame frame(int number) {
    static std::map<int, Frame> made;
    if (!made.contains(number)) {
      made[number] = render(world_from_camera(number));
      made[number].index = number;
      made[number].stamp = made[number].depth_stamp = stamp(number);
      made[number].name = std::to_string(number);
    }
    return made[number];
  }

  static std::vector<Frame> frames(int count = frame_count) {
    std::vector<Frame> frames;
    for (int k = 0; k < count; ++k) frames.push_back(frame(k));
    return frames;
  }

  static SE3 world_from_camera(int number) {
    SE3 pose(SO3::exp({0.0, -0.5, 0.0}), {0.7, 0.0, -1.0});
    for (int k = 0; k < number; ++k) {
      const double yaw = k < straight ? 0.0 : bend_deg * std::numbers::pi / 180.0;
      const SO3 half = SO3::exp({0.0, 0.5 * yaw, 0.0});
      pose = pose * SE3(half * half, half * Eigen::Vector3d(0.0, 0.0, step_m));
    }
    return pose;
  }
  /// Seen from the first camera.
  static SE3 first_from_camera(int number) { return world_from_camera(0).inverse() * world_from_camera(number); }
  static TimeNs stamp(int number) { return number * (ns_per_second / 30); }
  static double path_m() { return step_m * (frame_count - 1); }

 private:
  static Camera camera() { return {.width = 320, .height = 240, .fx = 260, .fy = 260, .cx = 159.5, .cy = 119.5}; }

  /// Textured with smooth spots of three sizes, the smallest 0.2 m.
  static double shade(const Eigen::Vector3d& p) {
    const auto wave = [](double a, double b) { return std::sin(a + 1.3 * std::sin(0.7 * b)); };
    double sum = 0.0;
    for (const double scale : {7.0, 15.0, 31.0})
      sum += wave(scale * p.x(), scale * p.y() + 7.0) + wave(1.3 * scale * p.y(), scale * p.z()) +
             wave(1.7 * scale * p.z() + 0.4, 1.1 * scale * p.x());
    return std::clamp(0.5 + 0.09 * sum, 0.0, 1.0);
  }

  /// The room measures 4 x 3 x 4 m around the origin.
  static Frame render(const SE3& pose) {
    Frame frame;
    frame.image = GrayImage(camera().width, camera().height);
    frame.depth = DepthImage(camera().width, camera().height);
    const Eigen::Vector3d half(2.0, 1.5, 2.0), from = pose.translation();
    const Eigen::Matrix3d rotation = pose.rotation().matrix();
    for (int y = 0; y < frame.image.height(); ++y) {
      for (int x = 0; x < frame.image.width(); ++x) {
        const Eigen::Vector3d ray =
            rotation * Eigen::Vector3d((x - camera().cx) / camera().fx, (y - camera().cy) / camera().fy, 1.0);
        double depth = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 3; ++i)
          if (std::abs(ray(i)) > 1e-9) depth = std::min(depth, (std::copysign(half(i), ray(i)) - from(i)) / ray(i));
        frame.depth.at(x, y) = static_cast<float>(depth);
        frame.image.at(x, y) = static_cast<std::uint8_t>(std::lround(255.0 * shade(from + depth * ray)));
      }
    }
    return frame;
  }
};

/// Errors of poses relative to the first one. A trajectory up to scale is scaled first.
struct DriveError {
  double rotation_deg = std::numeric_limits<double>::infinity();  ///< The largest.
  double position = std::numeric_limits<double>::infinity();      ///< Root mean square, as share of the path.
};

/// Of the poses at the stamps of all frames but `left_out`; infinite where one is missing or nothing moved.
inline DriveError drive_error(const Trajectory& poses, bool is_metric, const std::set<int>& left_out = {}) {
  std::map<TimeNs, SE3> at;
  for (const StampedPose& pose : poses) at[pose.stamp] = pose.world_from_body;
  std::vector<Eigen::Vector3d> ground_truth, estimate;
  double rotation = 0.0, both = 0.0, own = 0.0, squares = 0.0;
  for (int k = 0; k < DriveWorld::frame_count; ++k) {
    if (left_out.contains(k)) continue;
    if (!at.contains(DriveWorld::stamp(k))) return {};
    const SE3 moved = at[DriveWorld::stamp(0)].inverse() * at[DriveWorld::stamp(k)];
    const SE3 true_moved = DriveWorld::first_from_camera(k);
    ground_truth.push_back(true_moved.translation());
    estimate.push_back(moved.translation());
    both += ground_truth.back().dot(estimate.back());
    own += estimate.back().squaredNorm();
    rotation = std::max(rotation, (true_moved.rotation().inverse() * moved.rotation()).log().norm());
  }
  if (!(own > 0.0)) return {};
  const double scale = is_metric ? 1.0 : both / own;
  for (std::size_t k = 0; k < ground_truth.size(); ++k)
    squares += (scale * estimate[k] - ground_truth[k]).squaredNorm();
  return {rotation * 180.0 / std::numbers::pi,
          std::sqrt(squares / static_cast<double>(ground_truth.size())) / DriveWorld::path_m()};
}

}  // namespace rastro
