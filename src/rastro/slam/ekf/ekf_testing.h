// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/sensor/frame.h"
#include "rastro/slam/ekf/options.h"

namespace rastro::testing {

/// Walls and poles in the plane, in meters, as a laser sees them.
struct WallWorld {
  struct Wall {
    Eigen::Vector2d from, to;
  };
  struct Pole {
    Eigen::Vector2d middle;
    double radius = 0.05;
  };
  std::vector<Wall> walls;
  std::vector<Pole> poles;

  /// A closed polygon of walls.
  void add_polygon(const std::vector<Eigen::Vector2d>& corners);
  /// Distance along a ray to the first hit; infinite where nothing is hit.
  double distance(const Eigen::Vector2d& from, const Eigen::Vector2d& direction) const;
};

/// `beams` over `span` radians, centered on the x axis; Gaussian noise along the beams in meters.
LaserScan scan_of(const WallWorld& world, const SE2& world_from_laser, std::size_t beams, double span, double noise_m,
                  Random& random);

/// A robot that drives in circles among distinguishable landmarks, with noise exactly as the options model it.
/// Everything is in the frame of its first body pose.
struct LandmarkWorld {
  std::vector<Eigen::Vector2d> landmarks;
  double radius_m = 4.0;
  double step_m = 0.2;
  double reach_m = 6.0;         ///< Of the sensor, in all directions.
  double odometry_scale = 1.0;  ///< Factor on the noise that the options model.
  bool named = true;
  WallWorld walls;  ///< Scanned by a laser with 361 beams over 360 degrees; without walls there is no laser.
  double beam_noise_m = 0.01;
};

/// A room of 14 x 14 m with a recess, two pillars and two poles, around the circular trajectory.
LandmarkWorld room_world();

/// Landmarks in a ring around the circular trajectory, no two nearer than 1 m.
LandmarkWorld ring_world(std::size_t landmarks, std::uint64_t seed);

class LandmarkDrive {
 public:
  LandmarkDrive(const LandmarkWorld& world, const EkfOptions& options, std::uint64_t seed)
      : world_(world), options_(options), random_(seed) {}
  /// The next frame; the body moves before each frame but the first.
  Frame next();
  /// Ground-truth pose of the body at the last frame returned.
  const SE2& world_from_body() const { return ground_truth_; }

 private:
  SE2 noisy(const SE2& motion);
  void see(Frame& frame);

  LandmarkWorld world_;
  EkfOptions options_;
  Random random_;
  SE2 ground_truth_, odometry_;
  std::int64_t frames_ = 0;
};

}  // namespace rastro::testing
