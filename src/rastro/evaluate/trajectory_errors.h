// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/time.h"

namespace rastro {

/// Poses of a reference and of an estimate that belong together, pair by pair, as 4x4 matrices.
struct PairedPoses {
  std::vector<Eigen::Matrix4d> reference;
  std::vector<Eigen::Matrix4d> estimate;
  std::vector<TimeNs> stamps;  ///< Of the reference; empty where there are none.
};

struct ErrorStatistics {
  int count = 0;
  double rmse = 0.0, mean = 0.0, median = 0.0, max = 0.0, min = 0.0;
};

/// nullopt of nothing. The median of an even number is the mean of the middle two.
std::optional<ErrorStatistics> statistics_of(std::vector<double> errors);

/// Distances of the positions, metres: the absolute trajectory error (ATE) of poses that are already aligned. Sturm et
/// al. 2012, "A benchmark for the evaluation of RGB-D SLAM systems".
std::vector<double> position_errors(const PairedPoses& poses);

/// Length of the path through these poses up to each of them, metres.
std::vector<double> path_lengths(const std::vector<Eigen::Matrix4d>& poses);

/// How far apart the two poses of a relative error are.
struct RpeDelta {
  enum class Unit : std::uint8_t { frames, seconds, metres };
  double value = 1.0;
  Unit unit = Unit::frames;
};
/// "1f", "0.5s", "10m"; Error for anything else.
RpeDelta parse_rpe_delta(const std::string& text);
std::string as_text(const RpeDelta& delta);

struct RelativeError {
  double translation_m = 0.0;
  double rotation_rad = 0.0;
};

/// The error of the motion from pose `from` to pose `to`: inverse(reference motion) * estimated motion.
RelativeError relative_error(const PairedPoses& poses, std::size_t from, std::size_t to);

/// Relative pose errors (RPE) over `delta`. A pair ends at the first pose that is at least `delta` after its begin, in
/// lines, seconds or metres of the estimate's path. Consecutive pairs do not overlap: the next begins where the last
/// ended, the first where the first delta ended (as evo counts). With `all_pairs` one begins at every pose. Seconds
/// need stamps: without them there are no errors.
std::vector<RelativeError> relative_errors(const PairedPoses& poses, const RpeDelta& delta, bool all_pairs);

/// Errors over the path segments of one length.
struct SegmentErrors {
  double length_m = 0.0;
  int count = 0;
  double translation_percent = 0.0;  ///< Means over the segments; 0 where there are none.
  double rotation_deg_per_m = 0.0;
};

/// The KITTI odometry benchmark's errors (Geiger et al. 2012): a segment begins at every tenth pose and ends at the
/// first one at which the reference's path is longer than the length. The angle is taken from the trace, as there.
std::vector<SegmentErrors> segment_errors(const PairedPoses& poses, const std::vector<double>& lengths_m);

}  // namespace rastro
