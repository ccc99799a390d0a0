// SPDX-License-Identifier: Apache-2.0
#include "rastro/slam/ekf/frozen_odometry.h"

#include <algorithm>
#include <cmath>

#include "rastro/math/same_pose.h"

namespace rastro {
namespace {

constexpr int fewest_unmoved = 3, fewest_landmarks = 2;
/// A sum of squared Mahalanobis distances above its mean by this many of its standard deviations is no chance.
constexpr double clear_sigmas = 6.0;
/// People who walk by change fewer beams.
constexpr double moved_share = 0.4, still_share = 0.15, clear_m = 0.15, clear_range_share = 0.03;

}  // namespace

void FrozenOdometry::add(const Frame& frame) {
  const auto& odometry = frame.odometry_from_body;
  const bool unmoved = odometry && last_ && same_pose(*last_, *odometry);
  thaw_.reset();
  now_ = frame.stamp;
  if (unmoved) {
    add_unmoved(frame);
  } else {
    add_moved(frame);
  }
  last_ = odometry;
}

void FrozenOdometry::add_unmoved(const Frame& frame) {
  ++unmoved_;
  if (frozen_ || !frame.scan) return;
  if (!scan_) {
    scan_ = *frame.scan;
  } else if (unmoved_ >= fewest_unmoved) {
    const double changed = changed_share(*frame.scan);
    frozen_ = changed > moved_share;
    scan_still_ = changed < still_share;
  }
}

void FrozenOdometry::add_moved(const Frame& frame) {
  const double seconds = 1e-9 * static_cast<double>(now_ - since_);
  const double blind = 1e-9 * static_cast<double>(now_ - std::max(since_, recognized_));
  if (unmoved_ >= fewest_unmoved && blind_ >= std::min(unmoved_, most_blind))
    thaw_ = Thaw{seconds, blind / seconds, frozen_};
  // Its first step is no motion since the last frame unless nothing else told how the body moved.
  frozen_ = frozen_ && !thaw_ && unmoved_ > 0;
  unmoved_ = 0;
  since_ = frame.stamp;
  scan_.reset();
  scan_still_ = false;
}

double FrozenOdometry::changed_share(const LaserScan& scan) const {
  if (scan.ranges.size() != scan_->ranges.size()) return 0.0;
  int seen = 0, changed = 0;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.is_return(beam) || !scan_->is_return(beam)) continue;
    ++seen;
    const double before = scan_->ranges[beam];
    changed += std::abs(scan.ranges[beam] - before) > clear_m + clear_range_share * before ? 1 : 0;
  }
  return seen > 0 ? static_cast<double>(changed) / seen : 0.0;
}

void FrozenOdometry::judge(std::span<const LandmarkAssociation> associations) {
  using Kind = LandmarkAssociation::Kind;
  int known = 0;
  double sum = 0.0;
  for (const auto& [kind, landmark, distance] : associations) {
    if (kind != Kind::landmark && kind != Kind::contradicting) continue;
    ++known;
    sum += distance;
  }
  const double degrees_of_freedom = 2.0 * known;
  const bool moved =
      known >= fewest_landmarks && sum > degrees_of_freedom + clear_sigmas * std::sqrt(2.0 * degrees_of_freedom);
  // Landmarks that were off before tell of a wrong map.
  if (unmoved_ < fewest_unmoved) fitted_ = known >= fewest_landmarks && !moved;
  if (!frozen_ && unmoved_ >= fewest_unmoved) frozen_ = moved && fitted_ && !scan_still_;
}

void FrozenOdometry::end_frame(std::span<const LandmarkAssociation> associations) {
  const bool recognized = std::any_of(associations.begin(), associations.end(), [](const LandmarkAssociation& one) {
    return one.kind == LandmarkAssociation::Kind::landmark;
  });
  blind_ = recognized ? 0 : blind_ + 1;
  if (recognized) recognized_ = now_;
}

}  // namespace rastro
