// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/base/time.h"
#include "rastro/math/se2.h"
#include "rastro/sensor/frame.h"
#include "rastro/sensor/trajectory.h"

namespace rastro {

/// How fast the wheels said the body went, from `stamp` until the next one.
struct WheelVelocity {
  TimeNs stamp = 0;
  double forward = 0.0;   ///< m/s
  double yaw_rate = 0.0;  ///< rad/s, counterclockwise.
};

struct StampedObservation {
  TimeNs stamp = 0;
  LandmarkMeasurement measurement;
};

/// What a log of range-bearing landmarks and wheel odometry holds; both lists in the order of time.
struct LandmarkLog {
  std::vector<WheelVelocity> velocities;
  std::vector<StampedObservation> observations;
  std::vector<std::string> warnings;  ///< Each one plain line, about lines that were omitted.
};

// Readers of text. Blank lines and comments (#) are skipped; broken lines are omitted and counted in a warning that
// names the first as `where`:line. Error where not one line can be used.

/// rastro's own form, in any order:
///   odometry  STAMP FORWARD TURN        seconds, m/s, rad/s: holds until the next one
///   landmark  STAMP ID RANGE BEARING    seconds, number or - where unknown, m, rad counterclockwise from ahead
LandmarkLog parse_landmark_log(std::string_view text, std::string_view where);

/// Of UTIAS MRCLAM (Leung et al. 2011): "time forward yaw_rate" and "time barcode range bearing" a line, in s, m and
/// rad.
void parse_mrclam_odometry(LandmarkLog& log, std::string_view text, std::string_view where);
/// `subject_of_barcode` names the landmark of each barcode. Other robots (subjects 1 to 5) move and are omitted, as
/// are barcodes that nobody has: their counts are in the warnings.
void parse_mrclam_measurements(LandmarkLog& log, const std::map<std::int64_t, std::int64_t>& subject_of_barcode,
                               std::string_view text, std::string_view where);
/// "subject barcode" a line.
std::map<std::int64_t, std::int64_t> parse_mrclam_barcodes(std::string_view text, std::string_view where);
/// "time x y heading" a line.
Trajectory parse_mrclam_ground_truth(std::string_view text, std::string_view where);

/// One frame for each time at which landmarks were seen, with the odometry summed up from the first record on. A frame
/// before the first velocity has the identity.
std::vector<Frame> landmark_frames(const LandmarkLog& log);

/// Whether the front of a text is rastro's own form.
bool looks_like_landmark_log(std::string_view front);

}  // namespace rastro
