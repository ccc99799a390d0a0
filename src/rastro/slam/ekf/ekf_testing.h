// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "rastro/base/random.h"
#include "rastro/sensor/frame.h"
#include "rastro/slam/ekf/options.h"

namespace rastro::testing {

/// Walls and poles in the plane, in metres, for a laser.
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

  /// A closed row of walls.
  void add_polygon(const std::vector<Eigen::Vector2d>& corners);
  /// How far a ray goes; infinite where nothing is hit.
  double distance(const Eigen::Vector2d& from, const Eigen::Vector2d& direction) const;
};

/// `beams` over `span` radians about straight ahead; noise along the beams in metres.
LaserScan scan_of(const WallWorld& world, const SE2& world_from_laser, std::size_t beams, double span, double noise_m,
                  Random& random);

/// A robot that drives in circles among landmarks that it can tell apart, with noise exactly as the options say; all in
/// the frame of its first body.
struct LandmarkWorld {
  std::vector<Eigen::Vector2d> landmarks;
  double radius_m = 4.0;
  double step_m = 0.2;
  double reach_m = 6.0;         ///< Of the sensor, all round.
  double odometry_scale = 1.0;  ///< Times the noise the options call usual.
  bool named = true;
  WallWorld walls;  ///< For a laser of 361 beams over a full turn; without any, there is no laser.
  double beam_noise_m = 0.01;
};

/// A room of 14 x 14 m with a recess, two pillars and two poles, about the circle that is driven.
LandmarkWorld room_world();

/// Landmarks in a ring about the circle that is driven, no two nearer than 1 m.
LandmarkWorld ring_world(std::size_t landmarks, std::uint64_t seed);

class LandmarkDrive {
 public:
  LandmarkDrive(const LandmarkWorld& world, const EkfOptions& options, std::uint64_t seed)
      : world_(world), options_(options), random_(seed) {}
  /// The next frame; from the second on the body has moved.
  Frame next();
  /// Where the body truly is at the frame given last.
  const SE2& world_from_body() const { return truth_; }

 private:
  SE2 noisy(const SE2& motion);
  void see(Frame& frame);

  LandmarkWorld world_;
  EkfOptions options_;
  Random random_;
  SE2 truth_, odometry_;
  std::int64_t frames_ = 0;
};

}  // namespace rastro::testing
