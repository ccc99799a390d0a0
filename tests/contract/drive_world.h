// SPDX-License-Identifier: Apache-2.0
// A drive through a room in closed form, and how far an odometry is from it.
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "rastro/math/alignment.h"
#include "rastro/odometry/rgbd_tracking/room_testing.h"
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
    info.cameras.push_back({"rgb", PaperedRoom().camera, std::nullopt, "generated"});
    return info;
  }

  static Frame frame(int number) {
    static std::map<int, Frame> made;
    if (!made.contains(number)) {
      made[number] = PaperedRoom().frame(number, world_from_camera(number));
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
  static double path_m(int count = frame_count) { return step_m * (count - 1); }
};

/// How far poses are from the drive. A method that knows no lengths is scaled to it first.
struct DriveError {
  double rotation_deg = std::numeric_limits<double>::infinity();  ///< The largest, against the first pose.
  double position = std::numeric_limits<double>::infinity();      ///< Root mean square, as share of the path.
};

/// Of the poses at the stamps of the drive's frames, each of which `poses` must have (infinite errors else).
inline DriveError drive_error(const Trajectory& poses, bool is_metric) {
  std::map<TimeNs, SE3> at;
  for (const StampedPose& pose : poses) at[pose.stamp] = pose.world_from_body;
  std::vector<Eigen::Vector3d> truth, estimate;
  double rotation = 0.0;
  for (int k = 0; k < DriveWorld::frame_count; ++k) {
    if (!at.contains(DriveWorld::stamp(k))) return {};
    const SE3 moved = at[DriveWorld::stamp(0)].inverse() * at[DriveWorld::stamp(k)], true_moved = DriveWorld::first_from_camera(k);
    truth.push_back(true_moved.translation());
    estimate.push_back(moved.translation());
    rotation = std::max(rotation, (true_moved.rotation().inverse() * moved.rotation()).log().norm());
  }
  const auto aligned = align_points(truth, estimate, is_metric ? AlignmentKind::rigid : AlignmentKind::similarity);
  if (!aligned) return {};
  return {rotation * 180.0 / std::numbers::pi, aligned->rmse / DriveWorld::path_m()};
}

}  // namespace rastro
