// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/lsd/tracking/pose_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rastro {
namespace {

constexpr double deg_per_rad = 180.0 / std::numbers::pi;

SlamReason reason_of_failure(AlignmentFailure failure) {
  if (failure == AlignmentFailure::too_few_points) return SlamReason::too_few_points;
  return failure == AlignmentFailure::none ? SlamReason::none : SlamReason::poor_match;
}

PoseVerdict lost(const ImageAlignment& alignment) {
  return {PoseGrade::lost, reason_of_failure(alignment.failure),
          fmt::format("{}: {} pixels, {:.0f} % in view, {:.0f} % fit", to_string(alignment.failure), alignment.points,
                      100.0 * alignment.overlap, 100.0 * alignment.inlier_share)};
}

/// The first of the doubts that applies; grade tracking: none.
PoseVerdict first_doubt(const ImageAlignment& alignment, double mean_inverse_depth, const LsdOptions& options) {
  if (alignment.region_share < options.trusted_regions)
    return {PoseGrade::weak, SlamReason::poor_match,
            fmt::format("pixels fit in {:.0f} % of the regions of the image, need {:.0f} %",
                        100.0 * alignment.region_share, 100.0 * options.trusted_regions)};
  const double sigma =
      std::sqrt(std::max(0.0, alignment.covariance.topLeftCorner<3, 3>().trace())) * mean_inverse_depth;
  if (!(sigma <= options.trusted_sigma))
    return {PoseGrade::weak, SlamReason::degenerate,
            fmt::format("the position is certain to {:.3f} mean distances, need {:.3f}", sigma, options.trusted_sigma)};
  return {};
}

}  // namespace

double view_change_deg(const SE3& a_from_b, double mean_inverse_depth) {
  return deg_per_rad * (a_from_b.translation().norm() * mean_inverse_depth + a_from_b.rotation().log().norm());
}

PoseVerdict judge_pose(const ImageAlignment& alignment, double mean_inverse_depth, double jump_deg,
                       const LsdOptions& options) {
  if (!alignment.ok()) return lost(alignment);
  const double change = std::max(alignment.gain, 1.0 / alignment.gain);
  if (!(change <= options.max_gain))
    return {PoseGrade::lost, SlamReason::poor_match,
            fmt::format("intensities change by a factor of {:.2f} since the keyframe, at most {:.1f}", alignment.gain,
                        options.max_gain)};
  if (!(alignment.alike_share >= options.trusted_alike))
    return {PoseGrade::lost, SlamReason::poor_match,
            fmt::format("{:.0f} % of the regions of the image show what the keyframe shows, need {:.0f} %",
                        100.0 * alignment.alike_share, 100.0 * options.trusted_alike)};
  PoseVerdict verdict = first_doubt(alignment, mean_inverse_depth, options);
  if (verdict.grade == PoseGrade::tracking || jump_deg <= options.max_jump_deg) return verdict;
  return {PoseGrade::lost, SlamReason::implausible_motion,
          fmt::format("a jump of {:.1f} deg, and {}", jump_deg, verdict.detail)};
}

}  // namespace rastro
