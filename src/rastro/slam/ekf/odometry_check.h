// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/math/se2.h"

namespace rastro {

/// Measures how far odometry differs from the filter per meter of path length and per 45 degrees of rotation: METHODS 3
/// calls odometry usable if its error is less than 2 cm and 2 degrees. Segments begin and end where a landmark was
/// recognized, since in between the filter knows no better. The results are medians, because a filter that closes a
/// loop corrects the error of the whole loop within one segment. The filter's own noise is part of the difference.
class OdometryCheck {
 public:
  /// Both are poses of the same body at the same instant, each in its own world frame. `seen`: a landmark was
  /// recognized.
  void add(const SE2& odometry_from_body, const SE2& world_from_body, bool seen);
  /// Starts new segments after a gap in the odometry.
  void interrupt() { last_odometry_.reset(); }

  struct Result {
    int meters = 0;          ///< Number of one-meter segments measured.
    double error_m = 0.0;    ///< Median over them.
    int rotations = 0;       ///< Number of 45-degree rotations measured.
    double error_deg = 0.0;  ///< Median over them.
  };
  Result result() const;

 private:
  struct Pose {
    SE2 odometry_from_body, world_from_body;
  };
  /// From a frame with a landmark to the first one with a landmark after `length` of path or rotation.
  struct Segment {
    std::optional<Pose> start;
    double length = 0.0;
    std::vector<double> errors;  ///< Per unit of length.
  };
  /// The motion over a segment that is long enough and ends here, by odometry relative to the filter's.
  static std::optional<SE2> finished(Segment& segment, double length, double motion, const Pose& now, bool seen);

  std::optional<SE2> last_odometry_;
  Segment path_, rotation_;
};

/// One clause with numbers, and whether they are within the bound of METHODS 3.
std::string describe(const OdometryCheck::Result& result);

}  // namespace rastro
