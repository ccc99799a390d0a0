// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rastro/math/se2.h"

namespace rastro {

/// How far odometry differs from the filter over each metre of way and each 45 degrees of turn: METHODS 3 calls
/// odometry usable that errs by less than 2 cm and 2 degrees. Stretches begin and end where a landmark was recognised,
/// since between the filter knows no better. Medians, since a filter that closes a loop makes up for all the way around
/// it in one stretch. The filter's own noise is part of the difference.
class OdometryCheck {
 public:
  /// Both tell where the same body is at the same instant, each in its own frame; `seen`: a landmark was recognised.
  void add(const SE2& odometry_from_body, const SE2& world_from_body, bool seen);
  /// Begins anew, where odometry had a gap.
  void interrupt() { last_odometry_.reset(); }

  struct Result {
    int metres = 0;          ///< Stretches of one metre measured.
    double error_m = 0.0;    ///< Median over them.
    int turns = 0;           ///< Turns of 45 degrees measured.
    double error_deg = 0.0;  ///< Median over them.
  };
  Result result() const;

 private:
  struct Pose {
    SE2 odometry_from_body, world_from_body;
  };
  /// From a frame with a landmark to the first one with a landmark after `length` of way or turn.
  struct Stretch {
    std::optional<Pose> start;
    double length = 0.0;
    std::vector<double> errors;  ///< Per unit of length.
  };
  /// The motion since the start of a stretch that is long enough and ends here, by odometry as seen from the filter's.
  static std::optional<SE2> finished(Stretch& stretch, double length, double motion, const Pose& now, bool seen);

  std::optional<SE2> last_odometry_;
  Stretch way_, turn_;
};

/// One clause with numbers, and whether the bound of METHODS 3 is kept.
std::string describe(const OdometryCheck::Result& result);

}  // namespace rastro
