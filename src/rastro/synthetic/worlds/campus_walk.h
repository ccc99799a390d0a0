// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "rastro/synthetic/path.h"

namespace rastro::campus {

constexpr double rate_hz = 20.0, camera_height_m = 1.5;
constexpr int laps = 3;

/// A point of the tour on the floor with the direction there.
struct TourPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Meters.
  double heading = 0.0;                                ///< Radians from the x axis to the left, without jumps in a lap.
  double slope = 0.0;                                  ///< Rise per meter of the plan; not 0 on stairs.
};

/// The tour: the same lap three times, a little faster or slower, slow in turns and on stairs. Path lengths are
/// measured in the plan.
class Tour {
 public:
  Tour();

  double lap_m() const { return lap_m_; }
  double end_s() const { return lap_begin_s_.back(); }
  double lap_begin_s(int lap) const { return lap_begin_s_[static_cast<std::size_t>(lap)]; }
  /// Path length since the start, clamped to the tour.
  double distance_at(double time_s) const;
  /// At any path length; laps follow each other.
  TourPoint point(double distance) const;
  /// Path length within a lap of the point of the tour nearest to `position`.
  double nearest(const Eigen::Vector3d& position) const;
  /// Which visit (0 to laps - 1) of the place at path length `at_m` of a lap is nearest at a time: changes half a lap
  /// away from it.
  int visit(double time_s, double at_m) const;

 private:
  struct Piece {
    Eigen::Vector3d from;
    Eigen::Vector2d along;
    double straight = 0.0, heading = 0.0, slope = 0.0;
    double turn = 0.0, radius = 0.0;  ///< At its end: radians, to the left positive.
    double length() const;
  };
  void make_pieces();
  void make_times();

  std::vector<Piece> pieces_;
  double lap_m_ = 0.0;
  std::vector<double> seconds_;  ///< At steps of path length in a lap of usual speed.
  std::array<double, laps + 1> lap_begin_s_{};
};

/// Made once.
const Tour& tour();

/// Trajectory of the body camera.
CameraPath walk_path();

}  // namespace rastro::campus
