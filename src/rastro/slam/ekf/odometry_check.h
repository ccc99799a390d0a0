// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "rastro/math/se2.h"

namespace rastro {

/// How far odometry differs from the filter over each metre of way and each 45 degrees of turn: METHODS 3 calls
/// odometry usable that errs by less than 2 cm and 2 degrees. The filter's own corrections are part of the difference,
/// so it is an upper bound.
class OdometryCheck {
 public:
  /// Both tell where the same body is at the same instant, each in its own frame.
  void add(const SE2& odometry_from_body, const SE2& world_from_body);
  /// Begins anew from the next frame, where odometry had a gap.
  void interrupt() { last_.reset(); }

  struct Result {
    int metres = 0;          ///< Stretches of one metre measured.
    double error_m = 0.0;    ///< Root mean square over them.
    int turns = 0;           ///< Turns of 45 degrees measured.
    double error_deg = 0.0;  ///< Root mean square over them.
  };
  Result result() const;

 private:
  struct Pose {
    SE2 odometry_from_body, world_from_body;
  };
  static SE2 difference(const Pose& from, const Pose& to);

  std::optional<Pose> last_;
  Pose stretch_start_, turn_start_;
  double way_ = 0.0, turn_ = 0.0;
  int metres_ = 0, turns_ = 0;
  double squared_metres_ = 0.0, squared_turns_ = 0.0;
};

/// One clause with numbers, and whether the bound of METHODS 3 is kept.
std::string describe(const OdometryCheck::Result& result);

}  // namespace rastro
