// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/map/graph/map.h"
#include "rastro/sensor/source.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// A frame of a recording that shows what an earlier one showed.
struct Revisit {
  TimeNs stamp = 0, earlier_stamp = 0;
};

/// Those of a closures.yaml, as `rastro simulate` writes it. Throws Error naming the line for anything else.
std::vector<Revisit> parse_revisits(const std::string& text, const std::string& where);

/// A constraint of a map whose true relative pose is another one.
struct WrongClosure {
  KeyframeId from = 0, to = 0;
  TimeNs stamp = 0, earlier_stamp = 0;  ///< Of the keyframes.
  ConstraintKind kind = ConstraintKind::loop;
  double error_m = 0.0, error_deg = 0.0;  ///< Of the relative pose.
};

struct LoopClosureLimits {
  double gap_s = 15.0;       ///< Frames nearer in time are no revisit.
  double max_error_m = 0.5;  ///< Of the relative pose of a right loop closure,
  double max_error_deg = 10.0;
  double max_dt_s = 0.26;  ///< Between a revisit and the keyframe or frame that closes it.
  double max_ground_truth_gap_s = 1.0;
};

/// world_from_camera, as in maps of cameras, of a recording whose ground truth may be that of the body.
Trajectory camera_ground_truth(const SourceInfo& info);

/// How well a map recognized places.
struct LoopClosureScores {
  std::int64_t accepted = 0;  ///< Constraints between keyframes farther apart in time than the gap.
  std::int64_t wrong = 0;     ///< Of these: the true relative pose is another one.
  std::int64_t unknown = 0;   ///< Constraints without ground truth at one of their ends; not among the accepted.
  std::int64_t revisits = 0;  ///< Frames that see a place again, by the list.
  std::int64_t found = 0;     ///< Of these: a right constraint closes them, or the map places them in an old keyframe.
  std::vector<Revisit> missed;  ///< The others.
  std::vector<WrongClosure> wrong_ones;

  double precision() const {
    return accepted == 0 ? 1.0 : 1.0 - static_cast<double>(wrong) / static_cast<double>(accepted);
  }
  double recall() const { return revisits == 0 ? 0.0 : static_cast<double>(found) / static_cast<double>(revisits); }
};

/// Precision of the loop closures in a map, and recall of the true ones. A frame that the map holds relative to a
/// keyframe from an earlier visit, rightly, is found without a constraint of its own; so is one relative to a keyframe
/// that a right constraint closes. `ground_truth`: in the frame of the map's cameras, in the order of time. A map up to
/// scale has the scale that aligns its keyframes with it.
LoopClosureScores score_loop_closures(const Map& map, const std::vector<Revisit>& revisits,
                                      const Trajectory& ground_truth, const LoopClosureLimits& limits = {});

}  // namespace rastro
