// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rastro/base/time.h"

namespace rastro {

/// Associated poses of a reference and of an estimate, pair by pair, as 4x4 matrices.
struct PairedPoses {
  std::vector<Eigen::Matrix4d> reference;
  std::vector<Eigen::Matrix4d> estimate;
  std::vector<TimeNs> stamps;  ///< Of the reference; may be empty.
};

struct ErrorStatistics {
  int count = 0;
  double rmse = 0.0, mean = 0.0, median = 0.0, max = 0.0, min = 0.0;
};

/// nullopt without values. The median of an even number is the mean of the middle two.
std::optional<ErrorStatistics> statistics_of(std::vector<double> errors);

/// Distances of the positions, meters: the absolute trajectory error (ATE) of aligned poses. Sturm et al. 2012, "A
/// benchmark for the evaluation of RGB-D SLAM systems".
std::vector<double> position_errors(const PairedPoses& poses);

/// Path length up to each of these poses, meters.
std::vector<double> path_lengths(const std::vector<Eigen::Matrix4d>& poses);

/// Distance between the two poses of a relative error.
struct RpeDelta {
  enum class Unit : std::uint8_t { frames, seconds, meters };
  double value = 1.0;
  Unit unit = Unit::frames;
};
/// Parses "1f", "0.5s", "10m"; throws Error for anything else.
RpeDelta parse_rpe_delta(const std::string& text);
std::string as_text(const RpeDelta& delta);

struct RelativeError {
  double translation_m = 0.0;
  double rotation_rad = 0.0;
};

/// The error of the motion from pose `from` to pose `to`: inverse(reference motion) * estimated motion.
RelativeError relative_error(const PairedPoses& poses, std::size_t from, std::size_t to);

/// Relative pose errors (RPE) over `delta`. A pair ends at the first pose at least `delta` after its begin, in lines,
/// seconds or meters of the estimate's path. Consecutive pairs do not overlap: the next begins where the last ended,
/// the first where the first delta ended (as in evo). With `all_pairs` a pair begins at every pose. Seconds need
/// stamps: without them there are no errors.
std::vector<RelativeError> relative_errors(const PairedPoses& poses, const RpeDelta& delta, bool all_pairs);

/// Errors over the path segments of one length.
struct SegmentErrors {
  double length_m = 0.0;
  int count = 0;
  double translation_percent = 0.0;  ///< Means over the segments; 0 without segments.
  double rotation_deg_per_m = 0.0;
};

/// The KITTI odometry benchmark's errors (Geiger et al. 2012): a segment begins at every tenth pose and ends at the
/// first pose beyond the length along the reference's path. The angle is computed from the trace, as in the benchmark.
std::vector<SegmentErrors> segment_errors(const PairedPoses& poses, const std::vector<double>& lengths_m);

}  // namespace rastro
