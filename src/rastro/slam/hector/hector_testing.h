// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "rastro/math/se3.h"
#include "rastro/registration/walls_testing.h"
#include "rastro/sensor/frame.h"

namespace rastro::testing {

inline SE2 pose_of(double x, double y, double angle) { return {SO2::from_angle(angle), {x, y}}; }

inline SE2 planar(const SE3& pose) {
  return {SO2::from_angle(pose.rotation().log().z()), pose.translation().head<2>()};
}

/// A drive between walls: ground-truth poses, ten per second, and frames with exact scans.
struct WalledDrive {
  Walls walls;
  std::vector<SE2> world_from_body;  ///< In the walls' frame.
  double reach_m = 12.0;
  int beams = 360;  ///< Over 360 degrees.
  /// What wheel odometry measures for one meter in frames `slip_from` to `slip_to` (exclusive); otherwise it is exact.
  double measured_m = 1.0;
  std::size_t slip_from = 0, slip_to = 1'000'000;

  /// Ground truth in the frame of the first pose, as methods report it.
  SE2 ground_truth(std::size_t k) const { return world_from_body.front().inverse() * world_from_body[k]; }

  void go(const SE2& motion, int times) {
    for (int k = 0; k < times; ++k) world_from_body.push_back(world_from_body.back() * motion);
  }

  LaserScan scan(std::size_t k) const {
    LaserScan scan;
    scan.first_angle = -M_PI;
    scan.angle_step = 2.0 * M_PI / beams;
    scan.max_range = reach_m;
    scan.body_from_laser = pose_of(0.1, 0.0, 0.05);
    const SE2 laser = world_from_body[k] * scan.body_from_laser;
    for (int beam = 0; beam < beams; ++beam) {
      const double angle = scan.angle_of(static_cast<std::size_t>(beam));
      const Eigen::Vector2d direction = laser.rotation() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      scan.ranges.push_back(static_cast<float>(std::min(reach_m + 1.0, walls.range(laser.translation(), direction))));
    }
    return scan;
  }

  std::vector<Frame> frames() const {
    std::vector<Frame> frames;
    SE2 odometry = pose_of(3.0, -4.0, 2.0);
    for (std::size_t k = 0; k < world_from_body.size(); ++k) {
      if (k > 0) {
        const SE2 motion = world_from_body[k - 1].inverse() * world_from_body[k];
        const double scale = k >= slip_from && k < slip_to ? measured_m : 1.0;
        odometry = odometry * SE2(motion.rotation(), scale * motion.translation());
      }
      Frame& frame = frames.emplace_back();
      frame.index = static_cast<std::int64_t>(k);
      frame.stamp = 5'000'000'000 + 100'000'000 * frame.index;
      frame.scan = scan(k);
      frame.odometry_from_body = odometry;
    }
    return frames;
  }
};

/// A rectangular room of 7 x 5 m and a curved trajectory in it.
inline WalledDrive room_drive(int frames = 80) {
  WalledDrive drive;
  drive.walls.add_box(-2.0, -2.1, 5.0, 2.9);
  drive.world_from_body = {pose_of(0.0, -0.6, 0.3)};
  drive.go(SE2::exp({0.06, 0.0, 0.04}), frames - 1);
  return drive;
}

/// A little more than one loop through a ring of corridors 2 m wide, with a laser range of only 4 m. All corridors have
/// niches except the third, which is bare; there the wheels may slip.
inline WalledDrive ring_drive() {
  WalledDrive drive;
  drive.walls.add_box(-1.0, -1.0, 15.0, 9.0);
  drive.walls.add_box(1.0, 1.0, 13.0, 7.0);
  for (const double x : {0.6, 2.9, 4.4, 6.8, 9.9, 11.2}) drive.walls.add_box(x, -1.0, x + 0.3, -0.7);
  for (const double y : {1.3, 3.6, 5.2}) {
    drive.walls.add_box(14.7, y, 15.0, y + 0.4);
    drive.walls.add_box(-1.0, y + 0.5, -0.6, y + 0.9);
  }
  drive.reach_m = 4.0;
  drive.beams = 240;
  drive.slip_from = 125;
  drive.slip_to = 190;
  drive.world_from_body = {pose_of(2.0, 0.0, 0.0)};
  for (const int steps : {60, 40, 70, 40, 15}) {
    drive.go(pose_of(0.2, 0.0, 0.0), steps);
    drive.go(pose_of(0.0, 0.0, M_PI / 20.0), 10);
  }
  return drive;
}

}  // namespace rastro::testing
